"""Goals by message: "go PLACE" or "go X Y" is for all who hear it; "NAME: go PLACE" for the agent of that name.

X and Y are coordinates of the site; without an `Offset` of the map, these are those of the map, m.
"""

from __future__ import annotations

import re
from typing import Final

from intellwheels_agents.mind import Context
from intellwheels_maps.site_frame import from_site
from intellwheels_schemas.messages import Heard

_ORDER: Final = re.compile(r"(?:([a-z][a-z0-9_-]*): )?go (?:(-?\d{1,9}(?:\.\d+)?) (-?\d{1,9}(?:\.\d+)?)|(\S+))")

FARTHEST: Final = 10_000.0
"""Largest coordinate of a goal in the map frame, m."""


class GoalOrders:
    """Reads the goals that others say."""

    def __init__(self, context: Context) -> None:
        """Take the agent's name and the places of its map."""
        self._context = context

    def goal(self, message: Heard) -> tuple[float, float] | None:
        """Return the goal that a message gives to this agent, m; None if it gives none."""
        found = _ORDER.fullmatch(message.text.strip())
        if found is None or found.group(1) not in (None, self._context.agent):
            return None
        if found.group(2) is not None:
            x, y = from_site(self._context.map, (float(found.group(2)), float(found.group(3))))
            # The map ends at 10 km: what is farther away is no goal, but a number of another system.
            return (x, y) if max(abs(x), abs(y)) < FARTHEST else None
        place = self._context.places.get(found.group(4))
        return None if place is None else (place.x, place.y)
