"""The leaf of a door: a box for each part, with handles on both sides of the end away from the hinge."""

from __future__ import annotations

from collections.abc import Sequence

from intellwheels_schemas.messages import Part, Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer.drawings.body_look import BodyLook, extent
from intellwheels_viewer.drawings.solids import Solid, box, join, rod


def door(robot: Robot, *, cut: float | None = None) -> BodyLook:
    """Return the look of a door leaf.

    Args:
        robot: The document; the hinge is its centre of movement.
        cut: The height above which it is not drawn, as for walls; None for full height.
    """
    parts = [part for part in parts_of(robot) if cut is None or part.bottom < cut]
    tops = [part.top if cut is None else min(part.top, cut) for part in parts]
    paint = join(
        box(p.x - p.length / 2, p.x + p.length / 2, p.y - p.width / 2, p.y + p.width / 2, p.bottom, top)
        for p, top in zip(parts, tops, strict=True)
    )
    height = max(tops, default=0.0)
    hull = extent(parts)
    cap = (
        box(hull.rear, hull.front, hull.right, hull.left, max(height - 0.025, 0.0), height + 0.001)
        if parts
        else Solid()
    )
    return BodyLook(paint, dark=cap, light=_handles(parts, height), dark_rgb=(34, 92, 86))


def _handles(parts: Sequence[Part], height: float) -> Solid:
    if not parts or height < 0.4:
        return Solid()
    hull = extent(parts)
    end, back = (hull.rear, 1.0) if -hull.rear > hull.front else (hull.front, -1.0)
    x, z = end + 0.08 * back, min(1.0, height - 0.15)
    handles = []
    for face, out in ((hull.left, 1.0), (hull.right, -1.0)):
        y = face + 0.045 * out
        handles += [rod((x, face, z), (x, y, z), 0.012), rod((x, y, z), (x + 0.14 * back, y, z), 0.013)]
    return join(handles)
