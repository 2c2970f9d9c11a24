"""Faces of things seen by a sonar: the part of a face in its cone, the width of that part, and what hides it."""

from __future__ import annotations

import math

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
from intellwheels_server.world.kernels.line_of_sight import ray_to_polygon
from intellwheels_server.world.kernels.spatial_query import CENTRE_X, CENTRE_Y, COS, HIGH, LONG, LOW, SIN, WIDE
from intellwheels_server.world.kernels.wedge_distance import ray_to_box

# A thing that begins within this of the point of an echo does not hide it, m.
_SKIN = 1e-6

# Columns of a face block, float64[faces, 6], from the sonar: corner, next corner (anticlockwise), unit normal outwards.
FACE_COLUMNS = 6


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
def hidden(
    around: Floats,
    near: int,
    polygons: Ints,
    polygon_count: int,
    solids: Floats,
    links: Ints,
    edges: Floats,
    x: float,
    y: float,
    z: float,
    to_x: float,
    to_y: float,
) -> bool:
    """Return whether a gathered thing begins before a point, (to_x, to_y) from the sonar."""
    length = math.sqrt(to_x * to_x + to_y * to_y)
    if length <= _SKIN:
        return False
    dx, dy = to_x / length, to_y / length
    far = length - _SKIN
    for at in range(near):
        if not around[LOW, at] <= z < around[HIGH, at]:
            continue
        c, s = around[COS, at], around[SIN, at]
        from_x, from_y = x - around[CENTRE_X, at], y - around[CENTRE_Y, at]
        way = ray_to_box(
            c * from_x + s * from_y,
            c * from_y - s * from_x,
            c * dx + s * dy,
            c * dy - s * dx,
            around[LONG, at],
            around[WIDE, at],
        )
        if way < far:
            return True
    for at in range(polygon_count):
        piece = polygons[at]
        if solids[piece, LOW] <= z < solids[piece, HIGH]:
            way, _ = ray_to_polygon(edges, links[piece, FIRST_EDGE], links[piece, END_EDGE], x, y, dx, dy)
            if way < far:
                return True
    return False


@njit(cache=True, error_model="numpy")
def faces_of_box(around: Floats, at: int, x: float, y: float, faces: Floats) -> int:
    """Store a box's four faces as a face block; return 4."""
    c, s = around[COS, at], around[SIN, at]
    centre_x, centre_y = around[CENTRE_X, at] - x, around[CENTRE_Y, at] - y
    lx, ly = c * around[LONG, at], s * around[LONG, at]
    wx, wy = -s * around[WIDE, at], c * around[WIDE, at]
    for face in range(4):  # front right, front left, rear left, rear right
        along = 1.0 if face < 2 else -1.0
        across = 1.0 if face in (1, 2) else -1.0
        faces[face, 0] = centre_x + along * lx + across * wx
        faces[face, 1] = centre_y + along * ly + across * wy
    for face in range(4):
        faces[face, 2] = faces[(face + 1) % 4, 0]
        faces[face, 3] = faces[(face + 1) % 4, 1]
    faces[0, 4], faces[0, 5] = c, s
    faces[1, 4], faces[1, 5] = -s, c
    faces[2, 4], faces[2, 5] = -c, -s
    faces[3, 4], faces[3, 5] = s, -c
    return 4


@njit(cache=True, error_model="numpy")
def faces_of_piece(edges: Floats, first: int, end: int, x: float, y: float, faces: Floats) -> int:
    """Store a wall piece's faces as a face block, at most as many as there is room for; return how many."""
    count = min(end - first, faces.shape[0])
    for face in range(count):
        after = first + (face + 1) % (end - first)
        faces[face, 0] = edges[first + face, EDGE_X] - x
        faces[face, 1] = edges[first + face, EDGE_Y] - y
        faces[face, 2] = edges[after, EDGE_X] - x
        faces[face, 3] = edges[after, EDGE_Y] - y
        faces[face, 4] = edges[first + face, NORMAL_X]
        faces[face, 5] = edges[first + face, NORMAL_Y]
    return int(count)


@njit(cache=True, error_model="numpy")
def seen_width(faces: Floats, count: int, to_x: float, to_y: float) -> float:
    """Return the width of a thing across the way to a point of it, times the distance of that point."""
    least, most = np.inf, -np.inf
    for face in range(count):
        aside = to_x * faces[face, 1] - to_y * faces[face, 0]
        least, most = min(least, aside), max(most, aside)
    return most - least
