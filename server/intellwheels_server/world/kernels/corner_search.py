"""Finds a corner of a polygon inside a triangle. It decides only what rounding cannot change."""

from __future__ import annotations

import numpy as np
from numba import njit

from intellwheels_maps.crossing import NO_UNDERFLOW, SURE
from intellwheels_server.world.kernels.arrays import Floats, Ints


@njit(cache=True, error_model="numpy")
def corners_in_triangle(points: Floats, is_left: Ints, a: int, b: int, c: int) -> tuple[int, Ints]:
    """Look for corners inside a triangle or on its edge.

    Args:
        points: The corners, float64[n, 2], m.
        is_left: int64[n], 0 for corners that do not count.
        a: One corner of the triangle, by its index. They are anticlockwise. Nothing at their places counts.
        b: The next one.
        c: The last one.

    Returns:
        The first corner that is inside for certain, or -1, and then the corners that may be inside: rounding leaves it
        open for them.

    Source:
        The bound of certainty is that of `orientation`.
    """
    ax, ay, bx, by, cx, cy = points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1]
    left, right = min(ax, bx, cx), max(ax, bx, cx)
    low, high = min(ay, by, cy), max(ay, by, cy)
    count = 0
    open_ones = np.empty(0, dtype=np.int64)
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        if x < left or x > right or y < low or y > high or is_left[i] == 0:
            continue
        # A ring with holes comes back to some of its corners. What is at a corner of the triangle is not inside it.
        if (x == ax and y == ay) or (x == bx and y == by) or (x == cx and y == cy):
            continue
        certain = min(_side_of(ax, ay, bx, by, x, y), _side_of(bx, by, cx, cy, x, y), _side_of(cx, cy, ax, ay, x, y))
        if certain > 0:
            return i, open_ones[:0]
        if certain == 0:
            if count == open_ones.shape[0]:
                larger = np.empty(2 * count + 8, dtype=np.int64)
                larger[:count] = open_ones[:count]
                open_ones = larger
            open_ones[count] = i
            count += 1
    return -1, open_ones[:count]


@njit(cache=True, error_model="numpy", inline="always")
def _side_of(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> int:
    """Return 1 if a point is left of a line, -1 if it is right of it, 0 if rounding leaves it open."""
    one, other = (bx - ax) * (y - ay), (by - ay) * (x - ax)
    size = abs(one) + abs(other)
    if abs(one - other) > SURE * size and size > NO_UNDERFLOW:
        return 1 if one > other else -1
    return 0
