"""The frames of doorways: casings on both faces of a wall, a lining, and the wall over the door.

Pure. A map says where a doorway is and how wide. What is drawn is thinner than 2 cm on the walls, or above `HEAD`, so
that no body touches it. The leaves are agents.
"""

from __future__ import annotations

import math
from typing import Final

from intellwheels_schemas.messages import Doorway, Map
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.building_colours import BuildingColours, dimmed
from intellwheels_viewer.drawings.furniture import Painted
from intellwheels_viewer.drawings.rooms import depth_of, pieces_near
from intellwheels_viewer.drawings.solids import Solid, box, join

HEAD: Final = 2.1
"""Height of the clear opening, in metres: higher than any leaf and any person."""
CASING: Final = 0.08
"""Width of a casing, in metres."""
_PROUD: Final = 0.018
_LINING: Final = 0.004


def fittings(floor: Map, height: float | None, colours: BuildingColours) -> Painted:
    """Return the frames of all doorways by colour.

    Args:
        floor: The map.
        height: Where walls are cut, in metres; None for full height, with lintels.
        colours: Of the building.
    """
    frames, lintels = [], []
    for doorway in floor.doorway:
        back, front = depth_of(floor, doorway)
        tall = ceiling_at(floor, doorway)
        head = min(HEAD, tall) if height is None else min(HEAD, height)
        parts, over = _frame(doorway.width / 2, back, front, head, tall if height is None else None)
        turned = [each.turned(math.radians(doorway.heading_deg)).moved(doorway.x, doorway.y) for each in (parts, over)]
        frames.append(turned[0])
        lintels.append(turned[1])
    made: dict[palette.RGB, Solid] = {colours.frame: join(frames), dimmed(colours.wall, 0.9): join(lintels)}
    return {rgb: thing for rgb, thing in made.items() if len(thing.faces)}


def ceiling_at(floor: Map, doorway: Doorway) -> float:
    """Return the height of the walls beside a doorway, in metres; that of the highest wall if none is near."""
    near = pieces_near(floor, (doorway.x, doorway.y), doorway.width)
    heights = [wall.height for wall in floor.wall if wall.bottom <= 0.0]
    return max(heights, default=2.5) if near or heights else 2.5


def _frame(half: float, back: float, front: float, head: float, tall: float | None) -> tuple[Solid, Solid]:
    """Return a frame around an opening along x, and the wall over it, in the frame of the doorway."""
    y0, y1 = half, half + CASING
    parts = []
    for side in (1, -1):
        inner, outer = sorted((side * y0, side * y1))
        parts += [
            box(front, front + _PROUD, inner, outer, 0.0, head),
            box(back - _PROUD, back, inner, outer, 0.0, head),
        ]
        inner, outer = sorted((side * y0, side * (y0 - _LINING)))
        parts.append(box(back - _PROUD, front + _PROUD, inner, outer, 0.0, head))
    if tall is None or tall <= head:
        return join(parts), Solid()
    top = min(tall, head + CASING)
    parts += [
        box(front, front + _PROUD, -y1, y1, head, top),
        box(back - _PROUD, back, -y1, y1, head, top),
        box(back - _PROUD, front + _PROUD, -y0, y0, head - 0.02, head),
    ]
    return join(parts), box(back, front, -y0, y0, head, tall)
