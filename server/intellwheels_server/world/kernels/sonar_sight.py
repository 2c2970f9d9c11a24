"""What hides what from a sonar: a thing hides what is behind it only if it is wide enough to be heard itself."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import (
    EDGE_X,
    EDGE_Y,
    END_EDGE,
    FIRST_EDGE,
    PIECE_BOTTOM,
    PIECE_TOP,
    PIECE_X0,
    PIECE_X1,
    PIECE_Y0,
    PIECE_Y1,
    Floats,
)
from intellwheels_server.world.kernels.line_of_sight import ray_to_polygon
from intellwheels_server.world.kernels.sonar_scene import SKIN, Counts, Scene
from intellwheels_server.world.kernels.sonar_widths import body_span, gather_solid
from intellwheels_server.world.kernels.spatial_query import CENTRE_X, CENTRE_Y, COS, HIGH, LONG, LOW, SIN, WIDE
from intellwheels_server.world.kernels.wedge_distance import ray_to_box


@njit(cache=True, error_model="numpy")
def box_is_wide(box: int, z: float, dx: float, dy: float, least: float, scene: Scene, counts: Counts) -> bool:
    """Return whether a part, with those of its body that touch it, has a width across a direction, a unit vector."""
    boxes = scene.boxes
    c, s = boxes[box, COS], boxes[box, SIN]
    if 2.0 * (boxes[box, LONG] * abs(c * dy - s * dx) + boxes[box, WIDE] * abs(c * dx + s * dy)) >= least:
        return True
    low, high = body_span(box, z, dx, dy, boxes, scene.owners, counts.boxes, scene.members)
    return high - low >= least


@njit(cache=True, error_model="numpy")
def piece_is_wide(piece: int, dx: float, dy: float, least: float, scene: Scene) -> bool:
    """Return whether the solid of a wall piece has a width across a direction, a unit vector."""
    edges, low, high = scene.edges, np.inf, -np.inf
    for edge in range(scene.links[piece, FIRST_EDGE], scene.links[piece, END_EDGE]):
        aside = dx * edges[edge, EDGE_Y] - dy * edges[edge, EDGE_X]
        low, high = min(low, aside), max(high, aside)
    if high - low >= least:
        return True
    _, low, high = gather_solid(
        piece, dx, dy, least, scene.pieces, scene.links, edges, scene.cells, scene.frame, scene.members, scene.marks
    )
    return high - low >= least


@njit(cache=True, error_model="numpy")
def hiding_thing(
    x: float, y: float, z: float, to_x: float, to_y: float, gone: float, thin: float, through: int, scene: Scene,
    counts: Counts,
) -> int:  # fmt: skip
    """Return something that can be heard and begins on the way from a place to a point, -1 if there is nothing.

    Args:
        x: The place, m.
        y: The same.
        z: Height, m.
        to_x: The point, from the place, m.
        to_y: The same.
        gone: How far the sound has gone before the place, m.
        thin: What is narrower than this times the cube of its distance is not heard, 1/m2.
        through: A body that hides nothing, -1 for none.
        scene: What is around the sonar.
        counts: How much of it there is.

    Returns:
        The row of a part, or the number of parts and the index of a wall piece.
    """
    boxes, pieces, links, edges = scene.boxes, scene.pieces, scene.links, scene.edges
    length = math.sqrt(to_x * to_x + to_y * to_y)
    far = length - 2.0 * SKIN
    if far <= 0.0:
        return -1
    dx, dy = to_x / length, to_y / length
    x += SKIN * dx
    y += SKIN * dy
    for at in range(counts.boxes):
        if scene.owners[at] == through or not boxes[at, LOW] <= z < boxes[at, HIGH]:
            continue
        c, s = boxes[at, COS], boxes[at, SIN]
        from_x, from_y = x - boxes[at, CENTRE_X], y - boxes[at, CENTRE_Y]
        way = ray_to_box(
            c * from_x + s * from_y, c * from_y - s * from_x, c * dx + s * dy, c * dy - s * dx, boxes[at, LONG],
            boxes[at, WIDE],
        )  # fmt: skip
        if way < far:
            distance = gone + max(way, 0.0)
            if box_is_wide(at, z, dx, dy, thin * distance * distance * distance, scene, counts):
                return at
    x0, x1 = min(x, x + far * dx), max(x, x + far * dx)
    y0, y1 = min(y, y + far * dy), max(y, y + far * dy)
    for at in range(counts.near):
        piece = scene.near[at]
        if not pieces[piece, PIECE_BOTTOM] <= z < pieces[piece, PIECE_TOP]:
            continue
        if pieces[piece, PIECE_X0] > x1 or pieces[piece, PIECE_X1] < x0:
            continue
        if pieces[piece, PIECE_Y0] > y1 or pieces[piece, PIECE_Y1] < y0:
            continue
        way, _ = ray_to_polygon(edges, links[piece, FIRST_EDGE], links[piece, END_EDGE], x, y, dx, dy)
        if way < far:
            distance = gone + way
            if piece_is_wide(piece, dx, dy, thin * distance * distance * distance, scene):
                return counts.boxes + int(piece)
    return -1


@njit(cache=True, error_model="numpy")
def blocked(
    x: float, y: float, z: float, to_x: float, to_y: float, gone: float, thin: float, through: int, scene: Scene,
    counts: Counts,
) -> bool:  # fmt: skip
    """Return whether something hides a point: see `hiding_thing`."""
    return hiding_thing(x, y, z, to_x, to_y, gone, thin, through, scene, counts) >= 0


@njit(cache=True, error_model="numpy")
def outline(sides: Floats, count: int) -> tuple[float, float, float, float]:
    """Return directions of the right and the left edge of a convex thing, seen from the place of its side block."""
    right_x = left_x = sides[0, 0]
    right_y = left_y = sides[0, 1]
    for side in range(1, count):
        px, py = sides[side, 0], sides[side, 1]
        if right_x * py - right_y * px < 0.0:
            right_x, right_y = px, py
        if left_x * py - left_y * px > 0.0:
            left_x, left_y = px, py
    return right_x, right_y, left_x, left_y
