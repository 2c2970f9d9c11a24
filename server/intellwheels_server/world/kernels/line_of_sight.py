"""Whether one point can be seen from another, and where a ray enters a wall."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import (
    CELL,
    EDGE_X,
    EDGE_Y,
    END_EDGE,
    FIRST_EDGE,
    NORMAL_X,
    NORMAL_Y,
    ORIGIN_X,
    ORIGIN_Y,
    PIECE_BOTTOM,
    PIECE_TOP,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.grid import cell_of
from intellwheels_server.world.kernels.spatial_query import CENTRE_X, CENTRE_Y, COS, HIGH, LONG, LOW, SIN, WIDE
from intellwheels_server.world.kernels.wedge_distance import ray_to_box

# A thing that begins within this of the far point does not hide it, so that a point on a face is seen, m.
_SKIN = 1e-6


@njit(cache=True, error_model="numpy")
def ray_to_polygon(
    edges: Floats, first_edge: int, end_edge: int, x: float, y: float, dx: float, dy: float
) -> tuple[float, int]:
    """Return how far a ray travels until it enters a convex polygon, inf for never, and through which edge.

    Args:
        edges: Edge block of many polygons, each anticlockwise.
        first_edge: First edge of this polygon.
        end_edge: One past its last.
        x: Where the ray begins, m; 0 and -1 are returned from inside.
        y: The same.
        dx: Direction, a unit vector.
        dy: The same.
    """
    enter = 0.0
    leave = np.inf
    through = -1
    for k in range(first_edge, end_edge):
        beyond = edges[k, NORMAL_X] * (x - edges[k, EDGE_X]) + edges[k, NORMAL_Y] * (y - edges[k, EDGE_Y])
        rate = edges[k, NORMAL_X] * dx + edges[k, NORMAL_Y] * dy
        if rate < 0.0:
            way = -beyond / rate
            if way > enter:
                enter = way
                through = k
        elif rate > 0.0:
            leave = min(leave, -beyond / rate)
        elif beyond > 0.0:
            return np.inf, -1
    return (enter, through) if enter <= leave else (np.inf, -1)


@njit(cache=True, error_model="numpy")
def _box_way(boxes: Floats, box: int, x: float, y: float, dx: float, dy: float) -> float:
    """Return how far a ray travels to a box of a block, below 0 from inside, inf for never."""
    c, s = boxes[box, COS], boxes[box, SIN]
    from_x, from_y = x - boxes[box, CENTRE_X], y - boxes[box, CENTRE_Y]
    return float(
        ray_to_box(
            c * from_x + s * from_y,
            c * from_y - s * from_x,
            c * dx + s * dy,
            c * dy - s * dx,
            boxes[box, LONG],
            boxes[box, WIDE],
        )
    )


@njit(cache=True, error_model="numpy")
def in_sight(
    x: float,
    y: float,
    z: float,
    to_x: float,
    to_y: float,
    boxes: Floats,
    part_start: Ints,
    opaque: Ints,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
) -> bool:
    """Return whether nothing stands between two points at a height.

    Args:
        x: From where, m.
        y: The same.
        z: Height, m.
        to_x: To where, m.
        to_y: The same.
        boxes: Of the bodies, as `spatial_query.place_boxes` returns them.
        part_start: int64[n + 1], the first part of each body and the end.
        opaque: int64[n], 0 for bodies that hide nothing.
        pieces: Of the walls.
        links: Of the walls.
        edges: Of the walls.
        cells: Of the walls.
        frame: Of the walls.
    """
    dx, dy = to_x - x, to_y - y
    length = math.sqrt(dx * dx + dy * dy)
    if length <= _SKIN:
        return True
    dx /= length
    dy /= length
    far = length - _SKIN
    for body in range(opaque.shape[0]):
        if opaque[body] == 0:
            continue
        for box in range(part_start[body], part_start[body + 1]):
            if boxes[box, LOW] <= z < boxes[box, HIGH] and _box_way(boxes, box, x, y, dx, dy) < far:
                return False
    first_column = cell_of(min(x, to_x), frame[ORIGIN_X], frame[CELL], cells[0])
    last_column = cell_of(max(x, to_x), frame[ORIGIN_X], frame[CELL], cells[0])
    for row in range(
        cell_of(min(y, to_y), frame[ORIGIN_Y], frame[CELL], cells[1]),
        cell_of(max(y, to_y), frame[ORIGIN_Y], frame[CELL], cells[1]) + 1,
    ):
        first = cells[2 + row * cells[0] + first_column]
        last = cells[2 + row * cells[0] + last_column + 1]
        for at in range(first, last):
            piece = cells[at]
            if pieces[piece, PIECE_BOTTOM] <= z < pieces[piece, PIECE_TOP]:
                way, _ = ray_to_polygon(edges, links[piece, FIRST_EDGE], links[piece, END_EDGE], x, y, dx, dy)
                if way < far:
                    return False
    return True
