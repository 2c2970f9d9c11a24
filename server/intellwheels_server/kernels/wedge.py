"""The nearest part of a solid that a wedge sees, exactly.

A wedge is an apex, a unit direction and half of its opening angle, in (0, pi]. Its distance to
a solid is that from the apex to the nearest point of solid and wedge together. No fan of rays
is cast, so nothing slips through between two.

Why two cases are enough: a convex solid is seen from outside under less than half a turn,
and along what is seen of it the distance falls to the nearest point and rises behind. So
either the nearest point of the solid lies in the wedge, or the nearest visible point is where one of the two
sides of the wedge meets the solid.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def _ray_to_box(x: float, y: float, dx: float, dy: float, half_length: float, half_width: float) -> float:
    """Return how far the ray from (x, y), outside, along the unit vector (dx, dy) travels to a box at the origin."""
    enter = 0.0
    leave = np.inf
    if dx > 0.0:
        enter = max(enter, (-half_length - x) / dx)
        leave = (half_length - x) / dx
    elif dx < 0.0:
        enter = max(enter, (half_length - x) / dx)
        leave = (-half_length - x) / dx
    elif abs(x) > half_length:
        return np.inf
    if dy > 0.0:
        enter = max(enter, (-half_width - y) / dy)
        leave = min(leave, (half_width - y) / dy)
    elif dy < 0.0:
        enter = max(enter, (half_width - y) / dy)
        leave = min(leave, (-half_width - y) / dy)
    elif abs(y) > half_width:
        return np.inf
    return enter if enter <= leave else np.inf


@njit(cache=True, error_model="numpy")
def box_in_wedge(
    x: float,
    y: float,
    direction_x: float,
    direction_y: float,
    half_cos: float,
    half_sin: float,
    half_length: float,
    half_width: float,
    limit: float,
) -> float:
    """Return the distance from the apex of a wedge to a box, in the box's own frame.

    Args:
        x: Apex, from the centre of the box along its length, m.
        y: Apex, from the centre of the box along its width, m.
        direction_x: Direction of the wedge along the length, a unit vector.
        direction_y: Direction along the width.
        half_cos: Cosine of half the cone.
        half_sin: Sine of half the cone, >= 0; 0 sees all around.
        half_length: Half the length, > 0, m.
        half_width: Half the width, > 0, m.
        limit: A distance beyond which the answer does not matter, m.

    Returns:
        Metres; 0 when the apex is in the box or on its edge; inf when the wedge does not see the box, or (some of the
        time) when it is at `limit` or beyond.
    """
    dx = min(max(x, -half_length), half_length) - x
    dy = min(max(y, -half_width), half_width) - y
    square = dx * dx + dy * dy
    if square == 0.0:
        return 0.0
    if square > limit * limit:
        return np.inf
    ahead = direction_x * dx + direction_y * dy
    aside = direction_x * dy - direction_y * dx
    if half_sin * ahead >= half_cos * abs(aside):
        return math.sqrt(square)
    cx = direction_x * half_cos
    cy = direction_y * half_cos
    sx = direction_x * half_sin
    sy = direction_y * half_sin
    return min(
        _ray_to_box(x, y, cx - sy, cy + sx, half_length, half_width),
        _ray_to_box(x, y, cx + sy, cy - sx, half_length, half_width),
    )


@njit(cache=True, error_model="numpy")
def polygon_in_wedge(
    corners: np.ndarray,
    begin: int,
    end: int,
    x: float,
    y: float,
    direction_x: float,
    direction_y: float,
    half_cos: float,
    half_sin: float,
    limit: float,
) -> float:
    """Return the distance from the apex of a wedge to a convex polygon.

    Args:
        corners: float64[C, 2], corners of many polygons, each anticlockwise, m.
        begin: First corner of this polygon.
        end: One past its last.
        x: Apex, m.
        y: Apex, m.
        direction_x: Direction of the wedge, a unit vector.
        direction_y: The same.
        half_cos: Cosine of half the cone.
        half_sin: Sine of half the cone, >= 0; 0 sees all around.
        limit: A distance beyond which the answer does not matter, m.

    Returns:
        As `box_in_wedge`.
    """
    # From the apex: p the edge's first corner, q its second. The polygon turns left, so an edge that
    # runs clockwise around the apex shows it its outer face.
    outside = False
    best = np.inf
    best_x = best_y = 0.0
    px = corners[end - 1, 0] - x
    py = corners[end - 1, 1] - y
    for k in range(begin, end):
        qx = corners[k, 0] - x
        qy = corners[k, 1] - y
        if px * qy < py * qx:
            outside = True
            ex = qx - px
            ey = qy - py
            share = min(max(-(px * ex + py * ey) / (ex * ex + ey * ey), 0.0), 1.0)
            # From the nearer end, so that a corner comes out to the bit.
            if share <= 0.5:
                nx = px + share * ex
                ny = py + share * ey
            else:
                nx = qx - (1.0 - share) * ex
                ny = qy - (1.0 - share) * ey
            square = nx * nx + ny * ny
            if square < best:
                best = square
                best_x = nx
                best_y = ny
        px = qx
        py = qy
    if not outside:
        return 0.0
    if best > limit * limit:
        return np.inf
    ahead = direction_x * best_x + direction_y * best_y
    aside = direction_x * best_y - direction_y * best_x
    if half_sin * ahead >= half_cos * abs(aside):
        return math.sqrt(best)
    cx = direction_x * half_cos
    cy = direction_y * half_cos
    sx = direction_x * half_sin
    sy = direction_y * half_sin
    best = np.inf
    for side in range(2):
        rx = cx - sy if side == 0 else cx + sy
        ry = cy + sx if side == 0 else cy - sx
        px = corners[end - 1, 0] - x
        py = corners[end - 1, 1] - y
        left_p = rx * py - ry * px
        for k in range(begin, end):
            qx = corners[k, 0] - x
            qy = corners[k, 1] - y
            # A corner has one sign for both its edges: no ray passes between them.
            left_q = rx * qy - ry * qx
            if left_p >= 0.0 >= left_q and left_p > left_q and px * qy < py * qx:
                along = (left_p * (rx * qx + ry * qy) - left_q * (rx * px + ry * py)) / (left_p - left_q)
                best = min(best, along)
            px = qx
            py = qy
            left_p = left_q
    return best
