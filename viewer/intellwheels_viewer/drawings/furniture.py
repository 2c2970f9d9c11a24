"""The obstacles of a map, drawn by their names and at their exact size. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, TypeAlias

from intellwheels_schemas.agent_colours import FIXTURES
from intellwheels_schemas.messages import Obstacle
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.polygons import Point, anticlockwise
from intellwheels_viewer.drawings.solids import Solid, box, join, prism, slab

Painted: TypeAlias = dict[palette.RGB, Solid]
"""Solids by their colour."""

_SHEET: Final[palette.RGB] = (246, 247, 249)
_BLANKET: Final[palette.RGB] = (158, 194, 200)
_CLOTH: Final[palette.RGB] = (142, 158, 178)
_PORCELAIN: Final[palette.RGB] = (244, 246, 248)
_CABINET: Final[palette.RGB] = (214, 196, 168)
_EDGE: Final[palette.RGB] = (176, 154, 122)
_BOX: Final[palette.RGB] = (196, 168, 130)

_WOODEN: Final = ("wardrobe", "cupboard", "cabinet", "shelf", "bookcase", "locker", "drawer")
_TABLES: Final = ("table", "desk", "counter", "bench", "reception")


def furniture(obstacle: Obstacle, walls: Sequence[Point] = ()) -> Painted:
    """Return the solids of an obstacle by colour.

    Args:
        obstacle: The words of its name are separated by - and _; the last known word decides on its look.
        walls: Points on walls. The pillow of a bed is at the end nearest to one.
    """
    polygon = anticlockwise([(corner.x, corner.y) for corner in obstacle.corner])
    name, bottom, top = obstacle.name.lower(), obstacle.bottom, obstacle.top
    frame = rectangle(polygon)
    if frame is not None and "bed" in name.replace("_", "-").split("-"):
        return _bed(frame, bottom, top, walls)
    if "leg" in name:
        return {palette.METAL: prism(polygon, bottom, top)}
    if any(word in name for word in _TABLES):
        return {FIXTURES["table"]: prism(polygon, bottom, top)}
    if any(word in name for word in _WOODEN):
        return _wooden(polygon, bottom, top)
    if "sofa" in name or "chair" in name:
        return {_CLOTH: prism(polygon, bottom, top)}
    if any(word in name for word in ("bath", "basin", "toilet", "sink")):
        return {_PORCELAIN: prism(polygon, bottom, top)}
    return _edged(polygon, bottom, top, _BOX, _EDGE)


def merged(*parts: Painted) -> Painted:
    """Return the solids of several parts by colour."""
    made: dict[palette.RGB, list[Solid]] = {}
    for part in parts:
        for rgb, thing in part.items():
            made.setdefault(rgb, []).append(thing)
    return {rgb: join(things) for rgb, things in made.items()}


def _edged(polygon: Sequence[Point], bottom: float, top: float, body: palette.RGB, cap: palette.RGB) -> Painted:
    """Return a box with a lid of another colour, as wide as the box."""
    lid = min(0.04, (top - bottom) / 2)
    return {body: prism(polygon, bottom, top - lid), cap: prism(polygon, top - lid, top)}


def _wooden(polygon: Sequence[Point], bottom: float, top: float) -> Painted:
    return _edged(polygon, bottom, top, _CABINET, _EDGE)


Rectangle: TypeAlias = tuple[float, float, float, float, float]


def rectangle(polygon: Sequence[Point]) -> Rectangle | None:
    """Return the centre, length, width and heading of the longer side of a rectangle; None for other shapes."""
    if len(polygon) != 4:
        return None
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = polygon
    one, other = math.hypot(bx - ax, by - ay), math.hypot(cx - bx, cy - by)
    square = abs((bx - ax) * (cx - bx) + (by - ay) * (cy - by)) < 1e-6 * one * other
    if not square or math.hypot(ax + cx - bx - dx, ay + cy - by - dy) > 1e-6:
        return None
    long = (bx - ax, by - ay) if one >= other else (cx - bx, cy - by)
    return (ax + cx) / 2, (ay + cy) / 2, max(one, other), min(one, other), math.atan2(long[1], long[0])


def _bed(frame: Rectangle, bottom: float, top: float, walls: Sequence[Point]) -> Painted:
    """Return a bed with its head (x = -length / 2 before rotation) at the end nearest to a wall."""
    x, y, length, width, heading = frame
    heading = min((heading, heading + math.pi), key=lambda turn: _distance_of_head(x, y, length, turn, walls))
    tall = top - bottom
    half, mattress = length / 2, bottom + 0.62 * tall
    board = box(-half, -half + 0.05, -width / 2, width / 2, bottom, top)
    foot = box(half - 0.04, half, -width / 2, width / 2, bottom, bottom + 0.85 * tall)
    rail = box(
        -half + 0.05, half - 0.04, -width / 2 + 0.03, width / 2 - 0.03, bottom + 0.3 * tall, bottom + 0.45 * tall
    )
    linen = slab(
        0.0, 0.0, length - 0.1, width - 0.06, bottom + 0.45 * tall, mattress + 0.1 * tall, radius=0.06, bevel=0.03
    )
    pillow = slab(-half + 0.3, 0.0, 0.36, 0.66 * width, mattress + 0.05, top - 0.02, radius=0.09, bevel=0.05)
    blanket = slab(
        0.16 * length,
        0.0,
        0.62 * length,
        width - 0.02,
        bottom + 0.42 * tall,
        mattress + 0.17 * tall,
        radius=0.05,
        bevel=0.03,
    )
    made = {palette.METAL: join([board, foot, rail]), _SHEET: linen + pillow, _BLANKET: blanket}
    return {colour: each.turned(heading).moved(x, y) for colour, each in made.items()}


def _distance_of_head(x: float, y: float, length: float, heading: float, walls: Sequence[Point]) -> float:
    hx, hy = x - length / 2 * math.cos(heading), y - length / 2 * math.sin(heading)
    return min((math.hypot(wx - hx, wy - hy) for wx, wy in walls), default=0.0)
