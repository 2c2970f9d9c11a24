"""The nearest part of a solid that a wedge sees, exactly.

A wedge is an apex, a unit direction and half of its opening angle, in (0, pi]. Its distance to
a solid is that from the apex to the nearest point of solid and wedge together. No fan of rays
is cast, so nothing can be missed between two rays.

Why two cases are enough: seen from outside, a convex solid fills less than half a turn,
and along its visible edge the distance falls to the nearest point and rises after it. So
either the nearest point of the solid lies in the wedge, or the nearest visible point is where one of the two
sides of the wedge meets the solid.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import EDGE_X, EDGE_Y, NORMAL_X, NORMAL_Y, Floats

# Used for 1/0 of a ray along an axis: it is beyond all ranges, and 0 times it is still 0.
_NEVER = 1e300
_LEAST = 1e-300


@njit(cache=True, error_model="numpy", inline="always")
def ray_to_box(x: float, y: float, dx: float, dy: float, half_length: float, half_width: float) -> float:
    """Return how far the ray from (x, y), outside, along the unit vector (dx, dy) travels to a box at the origin."""
    per_x = 1.0 / dx if dx != 0.0 else _NEVER
    per_y = 1.0 / dy if dy != 0.0 else _NEVER
    x0 = (-half_length - x) * per_x
    x1 = (half_length - x) * per_x
    y0 = (-half_width - y) * per_y
    y1 = (half_width - y) * per_y
    enter = max(min(x0, x1), min(y0, y1))
    leave = min(max(x0, x1), max(y0, y1))
    return enter if (enter <= leave) & (leave >= 0.0) else np.inf


@njit(cache=True, error_model="numpy", inline="always")
def box_in_wedge(
    x: float,
    y: float,
    direction_x: float,
    direction_y: float,
    half_cos: float,
    half_sin: float,
    half_length: float,
    half_width: float,
) -> float:
    """Return the square of the distance from the apex of a wedge to a box, in the box's own frame.

    It has no branch, so that loops over boxes run on vectors.

    Args:
        x: Apex, from the centre of the box along its length, m.
        y: Apex, from the centre of the box along its width, m.
        direction_x: Direction of the wedge along the length, a unit vector.
        direction_y: Direction along the width.
        half_cos: Cosine of half the cone.
        half_sin: Sine of half the cone, >= 0; 0 sees all around.
        half_length: Half the length, > 0, m.
        half_width: Half the width, > 0, m.

    Returns:
        Square metres; 0 when the apex is in the box or on its edge; inf when the wedge does not see the box.
    """
    dx = min(max(x, -half_length), half_length) - x
    dy = min(max(y, -half_width), half_width) - y
    ahead = direction_x * dx + direction_y * dy
    aside = direction_x * dy - direction_y * dx
    seen = half_sin * ahead >= half_cos * abs(aside)
    cx = direction_x * half_cos
    cy = direction_y * half_cos
    sx = direction_x * half_sin
    sy = direction_y * half_sin
    side = min(
        ray_to_box(x, y, cx - sy, cy + sx, half_length, half_width),
        ray_to_box(x, y, cx + sy, cy - sx, half_length, half_width),
    )
    return dx * dx + dy * dy if seen else side * side


@njit(cache=True, error_model="numpy")
def polygon_in_wedge(
    edges: Floats,
    first_edge: int,
    end_edge: int,
    x: float,
    y: float,
    direction_x: float,
    direction_y: float,
    half_cos: float,
    half_sin: float,
) -> float:
    """Return the square of the distance from the apex of a wedge to a convex polygon.

    Args:
        edges: Edge block of many polygons, each anticlockwise.
        first_edge: First edge of this polygon.
        end_edge: One past its last.
        x: Apex, m.
        y: Apex, m.
        direction_x: Direction of the wedge, a unit vector.
        direction_y: The same.
        half_cos: Cosine of half the cone.
        half_sin: Sine of half the cone, >= 0; 0 sees all around.

    Returns:
        As `box_in_wedge`.
    """
    cx = direction_x * half_cos
    cy = direction_y * half_cos
    sx = direction_x * half_sin
    sy = direction_y * half_sin
    left_x = cx - sy
    left_y = cy + sx
    right_x = cx + sy
    right_y = cy - sx
    outside = False
    nearest = np.inf
    nearest_x = nearest_y = 0.0
    # The distances at which the rays along the two sides have entered all half planes, and leave the first one.
    # One pass without branches, because it cannot be predicted which edges face the apex.
    left_enter = right_enter = 0.0
    left_leave = right_leave = np.inf
    last = end_edge - 1
    px = edges[last, EDGE_X] - x
    py = edges[last, EDGE_Y] - y
    normal_x = edges[last, NORMAL_X]
    normal_y = edges[last, NORMAL_Y]
    for k in range(first_edge, end_edge):
        # From the apex: p is the edge's first corner, q its second; the edge runs along (-normal_y, normal_x).
        qx = edges[k, EDGE_X] - x
        qy = edges[k, EDGE_Y] - y
        beyond = -(normal_x * px + normal_y * py)
        facing = beyond > 0.0
        outside |= facing
        length = normal_x * (qy - py) - normal_y * (qx - px)
        along = min(max(normal_y * px - normal_x * py, 0.0), length)
        near_x = px - normal_y * along
        near_y = py + normal_x * along
        square = near_x * near_x + near_y * near_y
        better = facing & (square < nearest)
        nearest = square if better else nearest
        nearest_x = near_x if better else nearest_x
        nearest_y = near_y if better else nearest_y
        # A ray that runs along the edge never enters it from outside, never leaves it from inside.
        rate = normal_x * left_x + normal_y * left_y
        way = -beyond / (rate if rate != 0.0 else _LEAST)
        left_enter = way if (rate < 0.0) & (way > left_enter) else left_enter
        left_leave = way if (rate >= 0.0) & (way < left_leave) else left_leave
        rate = normal_x * right_x + normal_y * right_y
        way = -beyond / (rate if rate != 0.0 else _LEAST)
        right_enter = way if (rate < 0.0) & (way > right_enter) else right_enter
        right_leave = way if (rate >= 0.0) & (way < right_leave) else right_leave
        px = qx
        py = qy
        normal_x = edges[k, NORMAL_X]
        normal_y = edges[k, NORMAL_Y]
    if not outside:
        return 0.0
    ahead = direction_x * nearest_x + direction_y * nearest_y
    aside = direction_x * nearest_y - direction_y * nearest_x
    if half_sin * ahead >= half_cos * abs(aside):
        return nearest
    side = min(
        left_enter if left_enter <= left_leave else np.inf,
        right_enter if right_enter <= right_leave else np.inf,
    )
    return side * side
