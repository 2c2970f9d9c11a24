"""Uniform grids: they find the things that could be near a place, without a test of every thing.

A thing lies in every cell that its bounding box overlaps. A search over several cells meets such
a thing in each of them, and takes it only in the first cell that both the thing and the search
cover. So nothing is found twice, and no marks are needed.
"""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import Floats, Ints


@njit(cache=True, error_model="numpy")
def cell_of(x: float, origin: float, size: float, count: int) -> int:
    """Return the column (or row) of a coordinate, clipped to [0, count - 1]."""
    cell = np.floor((x - origin) / size)
    if not cell > 0.0:
        return 0
    return int(cell) if cell < count else count - 1


@njit(cache=True, error_model="numpy")
def fill_cells(boxes: Floats, origin_x: float, origin_y: float, size: float, columns: int, rows: int) -> Ints:
    """Return which boxes each cell of a grid holds, compressed by rows.

    Args:
        boxes: Bounding boxes, float64[n, >= 4]: x0, y0, x1, y1.
        origin_x: Left edge of the grid, m.
        origin_y: Lower edge of the grid, m.
        size: Edge of a cell, m, > 0.
        columns: Number of cells along x, >= 1.
        rows: Number of cells along y, >= 1.

    Returns:
        int64[2 + columns * rows + 1 + items]: columns, rows, for each cell (row by row) where its
        items start, one more for the end, then the items: indices of boxes, ascending in a cell.
        Starts count from the beginning of the array.
    """
    cells = columns * rows
    starts = np.zeros(cells + 1, dtype=np.int64)
    for i in range(boxes.shape[0]):
        for row in range(cell_of(boxes[i, 1], origin_y, size, rows), cell_of(boxes[i, 3], origin_y, size, rows) + 1):
            first = row * columns + cell_of(boxes[i, 0], origin_x, size, columns)
            last = row * columns + cell_of(boxes[i, 2], origin_x, size, columns)
            for cell in range(first, last + 1):
                starts[cell + 1] += 1
    head = 2 + cells + 1
    for cell in range(cells):
        starts[cell + 1] += starts[cell]
    grid = np.empty(head + starts[cells], dtype=np.int64)
    grid[0] = columns
    grid[1] = rows
    for cell in range(cells + 1):
        grid[2 + cell] = head + starts[cell]
    for i in range(boxes.shape[0]):
        for row in range(cell_of(boxes[i, 1], origin_y, size, rows), cell_of(boxes[i, 3], origin_y, size, rows) + 1):
            first = row * columns + cell_of(boxes[i, 0], origin_x, size, columns)
            last = row * columns + cell_of(boxes[i, 2], origin_x, size, columns)
            for cell in range(first, last + 1):
                grid[head + starts[cell]] = i
                starts[cell] += 1
    return grid
