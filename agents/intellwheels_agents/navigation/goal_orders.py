"""Goals by message: "go PLACE" or "go X Y", m, is for all who hear it; "NAME: go PLACE" for the agent of that name."""

from __future__ import annotations

import re
from typing import Final

from intellwheels_agents.mind import Context
from intellwheels_schemas.messages import Heard

_ORDER: Final = re.compile(r"(?:([a-z][a-z0-9_-]*): )?go (?:(-?\d{1,5}(?:\.\d+)?) (-?\d{1,5}(?:\.\d+)?)|(\S+))")


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
            return float(found.group(2)), float(found.group(3))
        place = self._context.places.get(found.group(4))
        return None if place is None else (place.x, place.y)
