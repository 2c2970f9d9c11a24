"""The cells of a grid that may hold an obstacle, each with one point, as arrays.

A cell is a whole number, so that a set of cells is an array, and a cell is a key of a dictionary.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Cells = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

ROW: Final = 1 << 32
"""A cell is its column times this, plus its row."""
NEIGHBOURS: Final = tuple(ROW * i + j for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j)
"""What to add to a cell to get each of the eight around it."""


def cells_at(x: Floats, y: Floats, cell: float) -> Cells:
    """Return the cells of points; x, y and the size of a cell are in m."""
    return np.floor(x / cell).astype(np.int64) * ROW + np.floor(y / cell).astype(np.int64)


class PointCells:
    """The cells that may hold an obstacle, each with a point.

    Attributes:
        cell: The cells.
        values: Rows of numbers with a column for a cell: `MAP_X` and `MAP_Y`, the point in the map's frame (m); `X` and
            `Y`, the same in the body's frame (m); `TRAVEL`, that of the body when it was stored (m); `TICK`, that of
            its reading.
        live: False in columns that were dropped, until `drop_dead`.
        columns: The column of each cell.
    """

    MAP_X, MAP_Y, X, Y, TRAVEL, TICK = range(6)

    def __init__(self) -> None:
        self.cell: Cells = np.empty(0, dtype=np.int64)
        self.values: Floats = np.empty((6, 0))
        self.live: Mask = np.empty(0, dtype=bool)
        self.columns: dict[int, int] = {}

    def here(self) -> Floats:
        """Return the points in the body's frame, of shape (n, 2), m."""
        return self.values[self.X : self.Y + 1, self.live].T

    def drop(self, dropped: Mask) -> None:
        """Drop the cells of some columns."""
        dropped = dropped & self.live
        if dropped.any():
            self.live[dropped] = False
            for cell in self.cell[dropped].tolist():
                del self.columns[cell]

    def drop_dead(self) -> None:
        """Remove the columns of dropped cells."""
        if not self.live.all():
            self.cell, self.values = self.cell[self.live], self.values[:, self.live]
            self.live = np.ones(len(self.cell), dtype=bool)
            self.columns = {cell: column for column, cell in enumerate(self.cell.tolist())}

    def put(self, cells: Cells, map_x: Floats, map_y: Floats, x: Floats, y: Floats, travel: float, tick: int) -> None:
        """Store points. A cell that is stored already, or that is there twice, has its last point."""
        known = size = len(self.cell)
        found = []
        for cell in cells.tolist():
            column = self.columns.get(cell)
            if column is None:
                column = self.columns[cell] = size
                size += 1
            found.append(column)
        if size > known:
            self.cell = np.concatenate([self.cell, np.empty(size - known, dtype=np.int64)])
            self.values = np.concatenate([self.values, np.empty((6, size - known))], axis=1)
            self.live = np.concatenate([self.live, np.ones(size - known, dtype=bool)])
        columns = np.array(found, dtype=np.int64)
        self.cell[columns] = cells
        for row, values in ((self.MAP_X, map_x), (self.MAP_Y, map_y), (self.X, x), (self.Y, y)):
            self.values[row, columns] = values
        self.values[self.TRAVEL, columns] = travel
        self.values[self.TICK, columns] = tick
