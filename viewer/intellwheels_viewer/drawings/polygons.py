"""Polygons on the floor: orientation, area, bounds and triangulation. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from mapbox_earcut import triangulate_float64

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
    """Return the triangles of an anticlockwise polygon as corner indices, in the same sense.

    Corners on a straight edge may belong to no triangle. A polygon that crosses itself gets some triangles, so that
    something is drawn; maps with such walls are refused earlier.
    """
    corners = triangulate_float64(np.array(points, dtype=np.float64), np.array([len(points)], dtype=np.uint32))
    return [(a, b, c) for a, b, c in corners.reshape(-1, 3).tolist()]
