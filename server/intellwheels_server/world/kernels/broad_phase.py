"""Broad phase: which bodies and wall pieces could meet in a tick, found by circles and grids.

The order in which they are found depends on the grids, but the set of them does not.
"""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import (
    CELL,
    HIGHEST,
    LOWEST,
    ORIGIN_X,
    ORIGIN_Y,
    PIECE_BOTTOM,
    PIECE_TOP,
    PIECE_X0,
    PIECE_X1,
    PIECE_Y0,
    PIECE_Y1,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.grid import cell_of, fill_cells

# With fewer bodies than this, testing every pair is cheaper than a grid.
_FEW = 12


@njit(cache=True, error_model="numpy")
def piece_apart(pieces: Floats, piece: int, x: float, y: float, radius: float) -> bool:
    """Return whether a circle is outside the bounding box of a wall piece."""
    dx = max(pieces[piece, PIECE_X0] - x, x - pieces[piece, PIECE_X1])
    dy = max(pieces[piece, PIECE_Y0] - y, y - pieces[piece, PIECE_Y1])
    dx, dy = max(dx, 0.0), max(dy, 0.0)
    return bool(dx * dx + dy * dy > radius * radius)


@njit(cache=True, error_model="numpy")
def _grown(items: Ints) -> Ints:
    larger = np.empty(2 * items.shape[0] + 16, dtype=np.int64)
    # Not by a slice: what numba compiles for its error message takes longer than all of this file.
    for k in range(items.shape[0]):
        larger[k] = items[k]
    return larger


@njit(cache=True, error_model="numpy")
def pieces_near(
    pieces: Floats, cells: Ints, frame: Floats, x: float, y: float, radius: float, low: float, high: float, found: Ints
) -> Ints:
    """Append the wall pieces that meet a circle and share z with [low, high), lower indices first.

    Args:
        pieces: Of the walls, as the next two.
        cells: Of the walls.
        frame: Of the walls.
        x: Centre of the circle.
        y: Centre of the circle.
        radius: Its radius, m.
        low: Lower end of z.
        high: Upper end of z.
        found: int64; the first says where its items end, the second where they begin, which is 2; changed.

    Returns:
        `found`, or a larger copy of it.
    """
    columns, row_count = cells[0], cells[1]
    size = frame[CELL]
    first = found[0]
    column0 = cell_of(x - radius, frame[ORIGIN_X], size, columns)
    column1 = cell_of(x + radius, frame[ORIGIN_X], size, columns)
    row0 = cell_of(y - radius, frame[ORIGIN_Y], size, row_count)
    row1 = cell_of(y + radius, frame[ORIGIN_Y], size, row_count)
    for row in range(row0, row1 + 1):
        for column in range(column0, column1 + 1):
            at = 2 + row * columns + column
            for k in range(cells[at], cells[at + 1]):
                piece = cells[k]
                if max(pieces[piece, PIECE_BOTTOM], low) >= min(pieces[piece, PIECE_TOP], high):
                    continue
                if piece_apart(pieces, piece, x, y, radius):
                    continue
                used = found[0]
                if used == found.shape[0]:
                    found = _grown(found)
                # Keep them sorted and each only once, although a piece may lie in several of the cells.
                place = used
                while place > first and found[place - 1] > piece:
                    place -= 1
                if place > first and found[place - 1] == piece:
                    continue
                for m in range(used, place, -1):
                    found[m] = found[m - 1]
                found[place] = piece
                found[0] = used + 1
    return found


@njit(cache=True, error_model="numpy")
def pairs_near(shape: Floats, pose: Floats, motion: Floats, wide: Floats) -> Ints:
    """Return the pairs of bodies whose circles meet, that share z, and of which at least one moves.

    Args:
        shape: Shape block.
        pose: float64[3, n].
        motion: float64[n], > 0 for bodies that move.
        wide: float64[n], radius of the circle of each body.

    Returns:
        int64[1 + 2 k or more]: 1 + 2 k, then k pairs (i, j), i < j.
    """
    n = pose.shape[1]
    found = np.empty(1 + 8 * n, dtype=np.int64)
    found[0] = 1
    if n < 2:
        return found
    x0 = y0 = np.inf
    x1 = y1 = -np.inf
    widest = 0.0
    for i in range(n):
        x0, y0 = min(x0, pose[rows.X, i] - wide[i]), min(y0, pose[rows.Y, i] - wide[i])
        x1, y1 = max(x1, pose[rows.X, i] + wide[i]), max(y1, pose[rows.Y, i] + wide[i])
        widest = max(widest, wide[i])
    # Cells as wide as the circle of a chair, or wider for a much larger body or bodies far apart. One cell if few.
    size = max(min(2.0 * widest, 2.0), widest / 8.0)
    while ((x1 - x0) / size + 1.0) * ((y1 - y0) / size + 1.0) > 8.0 * n:
        size *= 1.5
    if n < _FEW:
        size = max(x1 - x0, y1 - y0) + 1.0
    columns, row_count = int((x1 - x0) / size) + 1, int((y1 - y0) / size) + 1
    boxes = np.empty((n, 4))
    home = np.empty((n, 4), dtype=np.int64)
    for i in range(n):
        boxes[i, 0], boxes[i, 1] = pose[rows.X, i] - wide[i], pose[rows.Y, i] - wide[i]
        boxes[i, 2], boxes[i, 3] = pose[rows.X, i] + wide[i], pose[rows.Y, i] + wide[i]
        home[i, 0], home[i, 1] = cell_of(boxes[i, 0], x0, size, columns), cell_of(boxes[i, 1], y0, size, row_count)
        home[i, 2], home[i, 3] = cell_of(boxes[i, 2], x0, size, columns), cell_of(boxes[i, 3], y0, size, row_count)
    cells = fill_cells(boxes, x0, y0, size, columns, row_count)
    for i in range(n):
        if motion[i] <= 0.0:
            continue
        for row in range(home[i, 1], home[i, 3] + 1):
            for column in range(home[i, 0], home[i, 2] + 1):
                at = 2 + row * columns + column
                for k in range(cells[at], cells[at + 1]):
                    j = cells[k]
                    if j == i or (j < i and motion[j] > 0.0):
                        continue
                    dx, dy = pose[rows.X, j] - pose[rows.X, i], pose[rows.Y, j] - pose[rows.Y, i]
                    both = wide[i] + wide[j]
                    if dx * dx + dy * dy >= both * both:
                        continue
                    # Of all cells in which both lie, the first one counts.
                    if max(home[j, 0], home[i, 0]) != column or max(home[j, 1], home[i, 1]) != row:
                        continue
                    if max(shape[LOWEST, i], shape[LOWEST, j]) >= min(shape[HIGHEST, i], shape[HIGHEST, j]):
                        continue
                    used = found[0]
                    if used + 2 > found.shape[0]:
                        found = _grown(found)
                    found[used], found[used + 1] = min(i, j), max(i, j)
                    found[0] = used + 2
    return found
