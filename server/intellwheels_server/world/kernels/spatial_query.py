"""Finds the parts of bodies and the pieces of walls near a place, by uniform grids.

Kernels of range sensors begin with it. Bodies are placed and sorted into a grid once a tick. Things within the reach of
a sensor are gathered as boxes in rows of numbers, so that loops over them run on vectors. A wall piece that is no
rectangle is given by its index.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import (
    BOTTOM,
    EDGE_X,
    EDGE_Y,
    END_EDGE,
    FIRST_EDGE,
    HALF_LENGTH,
    HALF_WIDTH,
    NORMAL_X,
    NORMAL_Y,
    PART_X,
    PART_Y,
    PIECE_BOTTOM,
    PIECE_TOP,
    PIECE_X0,
    PIECE_X1,
    PIECE_Y0,
    PIECE_Y1,
    TOP,
    Floats,
    Ints,
    Walls,
)
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.grid import cell_of
from intellwheels_server.world.kernels.grid_search import BodyGrid, Place, bodies_near, pieces_near

# Columns of a block of boxes in the world, float64[boxes, 10]: centre, half extents along the axes, z range, unit
# vector of its length, half length and width. A wall piece that is no box has NaN for its half length.
CENTRE_X, CENTRE_Y, EXTENT_X, EXTENT_Y, LOW, HIGH, COS, SIN, LONG, WIDE = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9

# Slack of the culling tests, m: far above rounding, and far below the size of anything real.
SLACK = 1e-9

# The gathered boxes are filled up to a multiple of this: the width of the widest vectors.
LANES = 8

# Tolerance of a right angle, since corners are rounded. It moves no wall by 1e-10 m.
_SQUARE = 1e-14


class PlacedBodies(NamedTuple):
    """All bodies as boxes in the world, in a grid.

    Attributes:
        part_start: int64[n + 1], the first part of each body and the end.
        boxes: float64[parts, 10], columns `CENTRE_X` to `WIDE`.
        extents: float64[n, 4], centre and half extents in x and y, m.
        cell_start: int64[cells + 1], where the bodies of each cell begin; the cells of a row follow one another.
        cell_bodies: int64[n], bodies by cell.
        grid: The grid.
    """

    part_start: Ints
    boxes: Floats
    extents: Floats
    cell_start: Ints
    cell_bodies: Ints
    grid: BodyGrid


class Nearby(NamedTuple):
    """Buffers for the things that are gathered around one place after the other.

    Attributes:
        around: float64[10, boxes + pieces + LANES]: boxes, columns of a block of boxes as rows.
        polygons: int64[pieces], wall pieces that are no boxes.
        solids: float64[pieces, 10], wall pieces as boxes.
        filled: int64[pieces], 1 for those that are filled in.
        found: int64[pieces or bodies], what was found around a place.
        found_for: int64[pieces], as `pieces_near` takes it.
    """

    around: Floats
    polygons: Ints
    solids: Floats
    filled: Ints
    found: Ints
    found_for: Ints


class Found(NamedTuple):
    """The number of things gathered around a place.

    Attributes:
        of_bodies: Boxes that are parts of bodies; they come first.
        boxes: All boxes, a multiple of `LANES`, filled up with boxes of no height.
        polygons: Wall pieces that are no boxes.
    """

    of_bodies: int
    boxes: int
    polygons: int


@njit(cache=True, error_model="numpy")
def place_boxes(pose: Floats, parts: Floats, part_start: Ints) -> tuple[Floats, Floats]:
    """Return all parts as boxes in the world and the extent of each body.

    Returns:
        float64[parts, 10], columns `CENTRE_X` to `WIDE`; float64[n, 4]: centre and half extents in x and y.
    """
    count = pose.shape[1]
    boxes = np.empty((parts.shape[0], 10))
    extents = np.empty((count, 4))
    for body in range(count):
        x = pose[rows.X, body]
        y = pose[rows.Y, body]
        s, c = sincos(pose[rows.HEADING, body])
        low_x = low_y = np.inf
        high_x = high_y = -np.inf
        for part in range(part_start[body], part_start[body + 1]):
            half_length = parts[part, HALF_LENGTH]
            half_width = parts[part, HALF_WIDTH]
            centre_x = x + (c * parts[part, PART_X] - s * parts[part, PART_Y])
            centre_y = y + (s * parts[part, PART_X] + c * parts[part, PART_Y])
            extent_x = abs(c) * half_length + abs(s) * half_width
            extent_y = abs(s) * half_length + abs(c) * half_width
            boxes[part, CENTRE_X] = centre_x
            boxes[part, CENTRE_Y] = centre_y
            boxes[part, EXTENT_X] = extent_x
            boxes[part, EXTENT_Y] = extent_y
            boxes[part, LOW] = parts[part, BOTTOM]
            boxes[part, HIGH] = parts[part, TOP]
            boxes[part, COS] = c
            boxes[part, SIN] = s
            boxes[part, LONG] = half_length
            boxes[part, WIDE] = half_width
            low_x = min(low_x, centre_x - extent_x)
            high_x = max(high_x, centre_x + extent_x)
            low_y = min(low_y, centre_y - extent_y)
            high_y = max(high_y, centre_y + extent_y)
        if low_x > high_x:  # a body without parts cannot be seen
            low_x = high_x = x
            low_y = high_y = y
        extents[body, 0] = 0.5 * (low_x + high_x)
        extents[body, 1] = 0.5 * (low_y + high_y)
        extents[body, 2] = 0.5 * (high_x - low_x)
        extents[body, 3] = 0.5 * (high_y - low_y)
    return boxes, extents


@njit(cache=True, error_model="numpy")
def _fill_solid(piece: int, pieces: Floats, links: Ints, edges: Floats, solids: Floats) -> None:
    """Store a wall piece as a box; one that is no rectangle gets its bounding box and NaN for its half length."""
    centre_x = 0.5 * (pieces[piece, PIECE_X0] + pieces[piece, PIECE_X1])
    centre_y = 0.5 * (pieces[piece, PIECE_Y0] + pieces[piece, PIECE_Y1])
    first = links[piece, FIRST_EDGE]
    end = links[piece, END_EDGE]
    c = edges[first, NORMAL_X]
    s = edges[first, NORMAL_Y]
    rectangle = end - first == 4
    for edge in range(first + 1, end):
        c, s = -s, c
        rectangle &= (abs(edges[edge, NORMAL_X] - c) < _SQUARE) & (abs(edges[edge, NORMAL_Y] - s) < _SQUARE)
    length = width = 0.0
    for edge in range(first, end):
        dx = edges[edge, EDGE_X] - centre_x
        dy = edges[edge, EDGE_Y] - centre_y
        length = max(length, abs(c * dx + s * dy))
        width = max(width, abs(c * dy - s * dx))
    solids[piece, CENTRE_X] = centre_x
    solids[piece, CENTRE_Y] = centre_y
    solids[piece, EXTENT_X] = 0.5 * (pieces[piece, PIECE_X1] - pieces[piece, PIECE_X0])
    solids[piece, EXTENT_Y] = 0.5 * (pieces[piece, PIECE_Y1] - pieces[piece, PIECE_Y0])
    solids[piece, LOW] = pieces[piece, PIECE_BOTTOM]
    solids[piece, HIGH] = pieces[piece, PIECE_TOP]
    solids[piece, COS] = c
    solids[piece, SIN] = s
    solids[piece, LONG] = length if rectangle else np.nan
    solids[piece, WIDE] = width


@njit(cache=True, error_model="numpy")
def grid_of(extents: Floats) -> tuple[float, float, float, int, int, Ints, Ints]:
    """Return a grid over the centres of at least one body: origin, cell size, columns, rows, starts and bodies.

    The cells of a row follow one another, and so do their bodies.
    """
    count = extents.shape[0]
    low_x = extents[:, 0].min()
    low_y = extents[:, 1].min()
    width = extents[:, 0].max() - low_x
    height = extents[:, 1].max() - low_y
    # About two bodies a cell: (width / size + 1)(height / size + 1) = wanted + 1.
    wanted = max(1.0, 0.5 * count)
    span = width + height
    size = (span + math.sqrt(span * span + 4.0 * wanted * width * height)) / (2.0 * wanted)
    if not size > 0.0:
        size = 1.0
    columns = int(width / size) + 1
    row_count = int(height / size) + 1
    cell_start = np.zeros(columns * row_count + 1, np.int64)
    home = np.empty(count, np.int64)
    for body in range(count):
        column = cell_of(extents[body, 0], low_x, size, columns)
        cell = cell_of(extents[body, 1], low_y, size, row_count) * columns + column
        home[body] = cell
        cell_start[cell] += 1
    total = 0
    for cell in range(columns * row_count):
        total += cell_start[cell]
        cell_start[cell] = total
    cell_start[columns * row_count] = total
    cell_bodies = np.empty(count, np.int64)
    for body in range(count - 1, -1, -1):
        cell_start[home[body]] -= 1
        cell_bodies[cell_start[home[body]]] = body
    return low_x, low_y, size, columns, row_count, cell_start, cell_bodies


@njit(cache=True, error_model="numpy")
def place_bodies(pose: Floats, parts: Floats, part_start: Ints) -> PlacedBodies:
    """Return at least one body as boxes in the world, in a grid.

    Args:
        pose: float64[>= 3, n]: further rows do not matter.
        parts: Part block of the bodies.
        part_start: int64[n + 1], the first part of each body and the end.
    """
    boxes, extents = place_boxes(pose, parts, part_start)
    low_x, low_y, size, column_count, row_count, cell_start, cell_bodies = grid_of(extents)
    grid = BodyGrid(low_x, low_y, size, column_count, row_count, extents[:, 2].max(), extents[:, 3].max())
    return PlacedBodies(part_start, boxes, extents, cell_start, cell_bodies, grid)


# Inlined, so that the compiler sees that these arrays do not overlap: loops over them then run on vectors.
@njit(cache=True, error_model="numpy", inline="always")
def room_for(placed: PlacedBodies, walls: Walls) -> Nearby:
    """Return buffers for all that can be gathered around a place."""
    count, bodies = walls.pieces.shape[0], placed.extents.shape[0]
    around = np.empty((10, placed.boxes.shape[0] + count + LANES))
    solids, filled = np.empty((count, 10)), np.zeros(count, np.int64)
    found = np.empty(max(count, bodies), np.int64)
    return Nearby(around, np.empty(count, np.int64), solids, filled, found, np.full(count, -1, np.int64))


@njit(cache=True, error_model="numpy", inline="always")
def gather_bodies(
    place: Place, part_start: Ints, boxes: Floats, extents: Floats, cell_start: Ints, cell_bodies: Ints, grid: BodyGrid,
    around: Floats, found: Ints,
) -> int:  # fmt: skip
    """Gather the parts of bodies within reach of a place; return their number.

    Called for every place, so it takes the arrays of `PlacedBodies` and `Nearby` one by one, as `gather_walls` does.

    Args:
        place: The place.
        part_start: Of the bodies, as the next five.
        boxes: Of the bodies.
        extents: Of the bodies.
        cell_start: Of the bodies.
        cell_bodies: Of the bodies.
        grid: Of the bodies.
        around: Out.
        found: Scratch.
    """
    near = 0
    for at in range(bodies_near(place, extents, cell_start, cell_bodies, grid, found)):
        for part in range(part_start[found[at]], part_start[found[at] + 1]):
            for column in range(10):
                around[column, near] = boxes[part, column]
            near += 1
    return near


@njit(cache=True, error_model="numpy", inline="always")
def gather_walls(
    place: Place, pieces: Floats, links: Ints, edges: Floats, cells: Ints, frame: Floats, near: int, around: Floats,
    polygons: Ints, solids: Floats, filled: Ints, found: Ints, found_for: Ints,
) -> tuple[int, int]:  # fmt: skip
    """Gather the wall pieces within reach of a place, behind the bodies.

    Args:
        place: The place.
        pieces: Of the walls, as the next four.
        links: Of the walls.
        edges: Of the walls.
        cells: Of the walls.
        frame: Of the walls.
        near: The number of boxes so far.
        around: Of the `Nearby`, as the next five; in and out.
        polygons: Of the `Nearby`.
        solids: Of the `Nearby`.
        filled: Of the `Nearby`.
        found: Of the `Nearby`.
        found_for: Of the `Nearby`.

    Returns:
        The number of boxes afterwards, and the number of polygons.
    """
    polygon_count = 0
    for at in range(pieces_near(place, pieces, cells, frame, found, found_for)):
        piece = found[at]
        if filled[piece] == 0:
            _fill_solid(piece, pieces, links, edges, solids)
            filled[piece] = 1
        if solids[piece, LONG] > 0.0:
            for column in range(10):
                around[column, near] = solids[piece, column]
            near += 1
        else:
            polygons[polygon_count] = piece
            polygon_count += 1
    # Fill the last vector with boxes of no height, which nothing sees.
    while near % LANES != 0:
        for column in range(10):
            around[column, near] = 0.0
        near += 1
    return near, polygon_count
