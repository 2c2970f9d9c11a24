"""A body without a look of its own: a box for each part, and an arrow on top if it has motors."""

from __future__ import annotations

from intellwheels_schemas.messages import Robot
from intellwheels_schemas.rules import has_motors, parts_of
from intellwheels_viewer.drawings.body_look import BodyLook, extent
from intellwheels_viewer.drawings.solids import Solid, join, prism, slab


def plain(robot: Robot) -> BodyLook:
    """Return the look of a body: a box for each part, as large as the part."""
    parts = parts_of(robot)
    hull = extent(parts)
    small = 0.1 * min((hull.length, hull.width, hull.top))
    boxes = join(slab(p.x, p.y, p.length, p.width, p.bottom, p.top, radius=small, bevel=0.3 * small) for p in parts)
    arrow = Solid()
    if parts and has_motors(robot):
        (x, y), reach = hull.middle, 0.3 * min(hull.length, hull.width)
        corners = [
            (x + reach, y),
            (x - 0.7 * reach, y + 0.8 * reach),
            (x - 0.3 * reach, y),
            (x - 0.7 * reach, y - 0.8 * reach),
        ]
        arrow = prism(corners, hull.top, hull.top + 0.01)
    return BodyLook(
        boxes, light=arrow, light_rgb=(245, 246, 248), stripe=(hull.middle[0], hull.top + 0.012, 0.6 * hull.width)
    )
