"""A table: parts above the floor are wooden boards, parts on the floor are metal legs."""

from __future__ import annotations

from intellwheels_schemas.messages import Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.body_look import BodyLook
from intellwheels_viewer.drawings.solids import box, join, slab


def table(robot: Robot) -> BodyLook:
    """Return the look of a table, each part at its declared size."""
    parts = parts_of(robot)
    boards = [part for part in parts if part.bottom > 0.0] or list(parts)
    legs = [part for part in parts if part not in boards]
    return BodyLook(
        paint=join(slab(p.x, p.y, p.length, p.width, p.bottom, p.top, radius=0.04, bevel=0.006) for p in boards),
        light=join(
            box(p.x - p.length / 2, p.x + p.length / 2, p.y - p.width / 2, p.y + p.width / 2, p.bottom, p.top)
            for p in legs
        ),
        light_rgb=palette.METAL,
    )
