"""Polygons on the floor: orientation, area, bounds and triangulation. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

Point: TypeAlias = tuple[float, float]


def area(points: Sequence[Point]) -> float:
    """Return the area in square metres; negative when the corners run clockwise."""
    pairs = zip(points, [*points[1:], points[0]], strict=True)
    return sum(ax * by - bx * ay for (ax, ay), (bx, by) in pairs) / 2


def anticlockwise(points: Sequence[Point]) -> list[Point]:
    """Return the corners in anticlockwise order."""
    return list(points) if area(points) >= 0.0 else list(points)[::-1]


def bounds(points: Sequence[Point]) -> tuple[float, float, float, float]:
    """Return the least and largest x, then the least and largest y."""
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return min(xs), max(xs), min(ys), max(ys)


def triangles(points: Sequence[Point]) -> list[tuple[int, int, int]]:
    """Return the triangles of an anticlockwise simple polygon as corner indices, by ear clipping.

    After Meisters, "Polygons have ears", American Mathematical Monthly 82, 1975. A polygon that crosses itself is cut
    at any corner, so that something is drawn; maps with such walls are refused earlier.
    """
    left = list(range(len(points)))
    cut = []
    while len(left) > 3:
        ear = next((at for at in range(len(left)) if _is_ear(points, left, at)), 0)
        cut.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    return [*cut, (left[0], left[1], left[2])]


def _is_ear(points: Sequence[Point], left: Sequence[int], at: int) -> bool:
    before, corner, after = left[at - 1], left[at], left[(at + 1) % len(left)]
    a, b, c = points[before], points[corner], points[after]
    if _side(a, b, c) <= 0.0:
        return False
    others = (points[index] for index in left if index not in (before, corner, after))
    return not any(
        _side(a, b, p) >= 0.0 and _side(b, c, p) >= 0.0 and _side(c, a, p) >= 0.0 for p in others if p not in (a, b, c)
    )


def _side(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
