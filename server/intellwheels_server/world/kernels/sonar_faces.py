"""Rough things heard by a sonar: the nearest point of a segment in a wedge, and the faces of a box or a post."""

from __future__ import annotations

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import (
    EDGE_X,
    EDGE_Y,
    END_EDGE,
    FIRST_EDGE,
    NORMAL_X,
    NORMAL_Y,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.spatial_query import CENTRE_X, CENTRE_Y, COS, LONG, SIN, WIDE

# Columns of a side block, float64[sides, 6], from a place: corner, next corner (anticlockwise), unit normal outwards.


@njit(cache=True, error_model="numpy")
def segment_in_wedge(
    px: float,
    py: float,
    qx: float,
    qy: float,
    direction_x: float,
    direction_y: float,
    half_cos: float,
    half_sin: float,
) -> tuple[float, float, float]:
    """Return the nearest point of a segment inside a wedge at the origin: square of its distance, x, y; inf for none.

    Args:
        px: One end, from the apex, m.
        py: The same.
        qx: The other end.
        qy: The same.
        direction_x: Direction of the wedge, a unit vector.
        direction_y: The same.
        half_cos: Cosine of half the cone.
        half_sin: Sine of half the cone, >= 0; 0 sees all around.
    """
    ex, ey = qx - px, qy - py
    along = min(max(-(px * ex + py * ey) / (ex * ex + ey * ey), 0.0), 1.0)
    x, y = px + along * ex, py + along * ey
    if half_sin * (direction_x * x + direction_y * y) >= half_cos * abs(direction_x * y - direction_y * x):
        return x * x + y * y, x, y
    best, best_x, best_y = np.inf, 0.0, 0.0
    for side in (-half_sin, half_sin):
        ux, uy = direction_x * half_cos - direction_y * side, direction_y * half_cos + direction_x * side
        across = ux * ey - uy * ex
        if across == 0.0:
            continue
        way = (px * ey - py * ex) / across
        share = (px * uy - py * ux) / across
        if way >= 0.0 and 0.0 <= share <= 1.0 and way * way < best:
            best, best_x, best_y = way * way, way * ux, way * uy
    return best, best_x, best_y


@njit(cache=True, error_model="numpy")
def segment_between(
    px: float, py: float, qx: float, qy: float, right_x: float, right_y: float, left_x: float, left_y: float
) -> tuple[float, float, float]:
    """Return the nearest point of a segment between two rays from the origin: square of distance, x, y; inf for none.

    Args:
        px: One end, m.
        py: The same.
        qx: The other end.
        qy: The same.
        right_x: Direction of the right ray, of any length.
        right_y: The same.
        left_x: Direction of the left ray, less than half a turn anticlockwise from the right one.
        left_y: The same.
    """
    ex, ey = qx - px, qy - py
    first, last = 0.0, 1.0
    for side in range(2):
        if side == 0:
            value, rate = right_x * py - right_y * px, right_x * ey - right_y * ex
        else:
            value, rate = px * left_y - py * left_x, ex * left_y - ey * left_x
        if rate > 0.0:
            first = max(first, -value / rate)
        elif rate < 0.0:
            last = min(last, -value / rate)
        elif value < 0.0:
            return np.inf, 0.0, 0.0
    if first > last:
        return np.inf, 0.0, 0.0
    along = min(max(-(px * ex + py * ey) / (ex * ex + ey * ey), first), last)
    x, y = px + along * ex, py + along * ey
    return x * x + y * y, x, y


@njit(cache=True, error_model="numpy")
def sides_of_box(boxes: Floats, at: int, x: float, y: float, sides: Floats) -> int:
    """Store a box's four sides as a side block; return 4."""
    c, s = boxes[at, COS], boxes[at, SIN]
    centre_x, centre_y = boxes[at, CENTRE_X] - x, boxes[at, CENTRE_Y] - y
    lx, ly = c * boxes[at, LONG], s * boxes[at, LONG]
    wx, wy = -s * boxes[at, WIDE], c * boxes[at, WIDE]
    for side in range(4):  # front right, front left, rear left, rear right
        along = 1.0 if side < 2 else -1.0
        across = 1.0 if side in (1, 2) else -1.0
        sides[side, 0] = centre_x + along * lx + across * wx
        sides[side, 1] = centre_y + along * ly + across * wy
    for side in range(4):
        sides[side, 2] = sides[(side + 1) % 4, 0]
        sides[side, 3] = sides[(side + 1) % 4, 1]
    sides[0, 4], sides[0, 5] = c, s
    sides[1, 4], sides[1, 5] = -s, c
    sides[2, 4], sides[2, 5] = -c, -s
    sides[3, 4], sides[3, 5] = s, -c
    return 4


@njit(cache=True, error_model="numpy")
def sides_of_piece(piece: int, links: Ints, edges: Floats, x: float, y: float, sides: Floats) -> int:
    """Store a wall piece's sides as a side block, at most as many as there is room for; return how many."""
    first, end = links[piece, FIRST_EDGE], links[piece, END_EDGE]
    count = min(end - first, sides.shape[0])
    for side in range(count):
        after = first + (side + 1) % (end - first)
        sides[side, 0] = edges[first + side, EDGE_X] - x
        sides[side, 1] = edges[first + side, EDGE_Y] - y
        sides[side, 2] = edges[after, EDGE_X] - x
        sides[side, 3] = edges[after, EDGE_Y] - y
        sides[side, 4] = edges[first + side, NORMAL_X]
        sides[side, 5] = edges[first + side, NORMAL_Y]
    return int(count)


@njit(cache=True, error_model="numpy")
def is_inside(sides: Floats, count: int) -> bool:
    """Return whether the place of a side block is inside the thing or on its edge."""
    inside = True
    for side in range(count):
        inside &= sides[side, 4] * sides[side, 0] + sides[side, 5] * sides[side, 1] >= 0.0
    return inside
