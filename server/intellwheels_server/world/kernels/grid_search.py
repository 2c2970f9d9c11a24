"""Finds the bodies and the wall pieces within reach of a place, by their uniform grids."""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from intellwheels_server.world.kernels.arrays import (
    CELL,
    ORIGIN_X,
    ORIGIN_Y,
    PIECE_X0,
    PIECE_X1,
    PIECE_Y0,
    PIECE_Y1,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.grid import cell_of


class BodyGrid(NamedTuple):
    """A grid over the centres of bodies.

    Attributes:
        low_x: Left edge, m.
        low_y: Lower edge, m.
        size: Edge of a cell, m.
        column_count: Cells along x.
        row_count: Cells along y.
        widest_x: Largest half extent of a body in x, m.
        widest_y: The same in y.
    """

    low_x: float
    low_y: float
    size: float
    column_count: int
    row_count: int
    widest_x: float
    widest_y: float


class Place(NamedTuple):
    """A place around which things are gathered.

    Attributes:
        x: m.
        y: m.
        reach: Largest distance, m.
        owner: Body that is left out.
        number: Differs for each place that uses the same `Nearby`.
    """

    x: float
    y: float
    reach: float
    owner: int
    number: int


@njit(cache=True, error_model="numpy", inline="always")
def bodies_near(
    place: Place, extents: Floats, cell_start: Ints, cell_bodies: Ints, grid: BodyGrid, found: Ints
) -> int:  # fmt: skip
    """Find the bodies within reach of a place, but its owner; return their number.

    Called for every place, so it takes the arrays of `PlacedBodies` one by one.

    Args:
        place: The place.
        extents: Of the bodies, as the next three.
        cell_start: Of the bodies.
        cell_bodies: Of the bodies.
        grid: Of the bodies.
        found: int64[>= n], out.
    """
    x, y, reach, owner, _ = place
    low_x, low_y, size, columns, row_count, widest_x, widest_y = grid
    reach_square = reach * reach
    count = 0
    first_column = cell_of(x - reach - widest_x, low_x, size, columns)
    last_column = cell_of(x + reach + widest_x, low_x, size, columns)
    first_row = cell_of(y - reach - widest_y, low_y, size, row_count)
    last_row = cell_of(y + reach + widest_y, low_y, size, row_count)
    for row in range(first_row, last_row + 1):
        first = cell_start[row * columns + first_column]
        last = cell_start[row * columns + last_column + 1]
        for at in range(first, last):
            body = cell_bodies[at]
            gap_x = max(abs(extents[body, 0] - x) - extents[body, 2], 0.0)
            gap_y = max(abs(extents[body, 1] - y) - extents[body, 3], 0.0)
            if body != owner and gap_x * gap_x + gap_y * gap_y <= reach_square:
                found[count] = body
                count += 1
    return count


@njit(cache=True, error_model="numpy", inline="always")
def pieces_near(
    place: Place, pieces: Floats, cells: Ints, frame: Floats, found: Ints, found_for: Ints
) -> int:  # fmt: skip
    """Find the wall pieces within reach of a place; return their number.

    Args:
        place: The place.
        pieces: Of the walls, as the next two.
        cells: Of the walls.
        frame: Of the walls.
        found: int64[>= pieces], out.
        found_for: int64[pieces], the last place at which a piece was looked at, -1 for none; in and out.
    """
    x, y, reach, _, number = place
    reach_square = reach * reach
    count = 0
    first_column = cell_of(x - reach, frame[ORIGIN_X], frame[CELL], cells[0])
    last_column = cell_of(x + reach, frame[ORIGIN_X], frame[CELL], cells[0])
    first_row = cell_of(y - reach, frame[ORIGIN_Y], frame[CELL], cells[1])
    last_row = cell_of(y + reach, frame[ORIGIN_Y], frame[CELL], cells[1])
    for row in range(first_row, last_row + 1):
        first = cells[2 + row * cells[0] + first_column]
        last = cells[2 + row * cells[0] + last_column + 1]
        for at in range(first, last):
            piece = cells[at]
            if found_for[piece] == number:
                continue
            found_for[piece] = number
            gap_x = max(pieces[piece, PIECE_X0] - x, x - pieces[piece, PIECE_X1], 0.0)
            gap_y = max(pieces[piece, PIECE_Y0] - y, y - pieces[piece, PIECE_Y1], 0.0)
            if gap_x * gap_x + gap_y * gap_y <= reach_square:
                found[count] = piece
                count += 1
    return count
