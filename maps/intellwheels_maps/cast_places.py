"""Which place of the map belongs to which agent of a cast, so that nobody else takes it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from intellwheels_maps.library import robot
from intellwheels_schemas.messages import Cast, Map


def cast_places(cast: Iterable[Cast], floor: Map, *, beside: Path | None = None) -> dict[str, str]:
    """Return the place of each agent: its own, or the first one for its kind that no other agent has.

    Args:
        cast: The agents.
        floor: The map. An agent without a place is left out if no place is left for it.
        beside: The folder from which paths of robots start; default: the working directory.

    Raises:
        WireError: The robot of an agent without a place cannot be read.
    """
    agents = tuple(cast)
    found = {one.name: one.place for one in agents if one.place is not None}
    for one in agents:
        if one.place is None:
            # The program of a Command brings a body that nobody knows yet.
            kind = robot(one.robot, beside=beside).kind if one.robot else "wheelchair"
            spots = floor.grid.position if floor.grid is not None else ()
            fitting = [spot.name for spot in spots if not spot.kinds or kind in spot.kinds]
            free = [name for name in fitting if name not in found.values()]
            if free:
                found[one.name] = free[0]
    return found
