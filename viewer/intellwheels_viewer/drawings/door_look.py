"""The leaf of a door: a wooden board with a panel and a kick plate on each face, hinges, and handles at the far end.

Pure. Its frame is of the same wood, see `door_frames`. Only the handles stand out by more than 1 cm.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from intellwheels_schemas.messages import Part, Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer.drawings.body_look import BodyLook, Extent, extent
from intellwheels_viewer.drawings.solids import Solid, box, join, rod
from intellwheels_viewer.palette import RGB

EDGE: Final[RGB] = (92, 58, 32)
"""The dark wood of edges and panels, sRGB."""
_PROUD: Final = 0.005
_STILE: Final = 0.12
"""Width of the board around a panel, in metres."""
_KICK: Final = 0.22
"""Height of the kick plate, in metres."""
_LOW: Final = 0.4
"""A lower leaf is a plain board."""


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
    if not parts:
        return BodyLook(paint)
    height, hull = max(tops), extent(parts)
    edge = box(hull.rear, hull.front, hull.right, hull.left, max(height - 0.025, 0.0), height + 0.001)
    dark, light = [edge, *_panels(hull, height)], [*_kick_plates(hull, height), *_hinges(hull, height)]
    return BodyLook(paint, dark=join(dark), light=join([*light, _handles(parts, height)]), dark_rgb=EDGE)


def _faces(hull: Extent) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return from where to where what lies on each face extends across the leaf, in metres."""
    return (hull.right - _PROUD, hull.right), (hull.left, hull.left + _PROUD)


def _panels(hull: Extent, height: float) -> list[Solid]:
    """Return a frame of dark lines on each face, which reads as a panel."""
    x0, x1 = hull.rear + _STILE, hull.front - _STILE
    low, high, line = _KICK + 0.08, height - 0.1, 0.03
    if height < _LOW or x1 - x0 < 0.2 or high - low < 0.2:
        return []
    return [
        box(a, b, y0, y1, bottom, top)
        for y0, y1 in _faces(hull)
        for a, b, bottom, top in (
            (x0, x1, low, low + line),
            (x0, x1, high - line, high),
            (x0, x0 + line, low, high),
            (x1 - line, x1, low, high),
        )
    ]


def _kick_plates(hull: Extent, height: float) -> list[Solid]:
    if height < _LOW:
        return []
    return [box(hull.rear + 0.03, hull.front - 0.03, y0, y1, 0.02, _KICK) for y0, y1 in _faces(hull)]


def _hinges(hull: Extent, height: float) -> list[Solid]:
    """Return two hinges at the end at which the leaf turns."""
    if height < _LOW:
        return []
    x = hull.front - 0.018 if -hull.rear > hull.front else hull.rear + 0.018
    return [rod((x, hull.left, z - 0.07), (x, hull.left, z + 0.07), 0.018) for z in (0.2, height - 0.2)]


def _handles(parts: Sequence[Part], height: float) -> Solid:
    if not parts or height < _LOW:
        return Solid()
    hull = extent(parts)
    end, back = (hull.rear, 1.0) if -hull.rear > hull.front else (hull.front, -1.0)
    x, z = end + 0.09 * back, min(1.0, height - 0.12)
    handles = []
    for face, out in ((hull.left, 1.0), (hull.right, -1.0)):
        y = face + 0.043 * out
        near, far = sorted((face, face + _PROUD * out))
        handles.append(box(x - 0.03, x + 0.03, near, far, z - 0.1, z + 0.06))
        handles += [rod((x, face, z), (x, y, z), 0.016), rod((x, y, z), (x + 0.2 * back, y, z), 0.016)]
    return join(handles)
