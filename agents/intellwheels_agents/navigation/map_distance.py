"""The distance from any point to the nearest thing that the map has at a height."""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

from intellwheels_agents.navigation.array_angles import Floats
from intellwheels_agents.navigation.footprint_clearance import Solid

CELL: Final = 0.05
"""Size of a cell, m."""
FARTHEST: Final = 0.8
"""Distances above this are not told apart, m."""


class MapDistance:
    """The distances on a grid."""

    def __init__(self, solids: list[Solid], height: float) -> None:
        """Take the solids of a map that a sensor at a height (m) sees."""
        seen = [solid for solid in solids if solid.bottom <= height < solid.top]
        xs = [x for solid in seen for x, _ in solid.corners] or [0.0]
        ys = [y for solid in seen for _, y in solid.corners] or [0.0]
        self._x, self._y = min(xs) - 1.0, min(ys) - 1.0
        self._columns = int((max(xs) + 1.0 - self._x) / CELL) + 1
        self._rows = int((max(ys) + 1.0 - self._y) / CELL) + 1
        self._field: npt.NDArray[np.float32] = np.full((self._rows, self._columns), FARTHEST, dtype=np.float32)
        for solid in seen:
            for a, b in zip(solid.corners, (*solid.corners[1:], solid.corners[0]), strict=True):
                self._mark(a, b)

    def _mark(self, a: tuple[float, float], b: tuple[float, float]) -> None:
        west = max(0, int((min(a[0], b[0]) - FARTHEST - self._x) / CELL))
        east = min(self._columns, int((max(a[0], b[0]) + FARTHEST - self._x) / CELL) + 1)
        south = max(0, int((min(a[1], b[1]) - FARTHEST - self._y) / CELL))
        north = min(self._rows, int((max(a[1], b[1]) + FARTHEST - self._y) / CELL) + 1)
        x = (self._x + CELL * np.arange(west, east))[None, :]
        y = (self._y + CELL * np.arange(south, north))[:, None]
        ex, ey = b[0] - a[0], b[1] - a[1]
        square = ex * ex + ey * ey
        share = np.clip(((x - a[0]) * ex + (y - a[1]) * ey) / square, 0.0, 1.0) if square else 0.0 * (x + y)
        dx, dy = x - a[0] - share * ex, y - a[1] - share * ey
        part = self._field[south:north, west:east]
        np.minimum(part, np.sqrt(dx * dx + dy * dy).astype(np.float32), out=part)

    def at(self, x: Floats, y: Floats) -> Floats:
        """Return the distances of points, m, at the centres of their cells; `FARTHEST` outside the map."""
        i, j = np.floor((x - self._x) / CELL + 0.5), np.floor((y - self._y) / CELL + 0.5)
        outside = (i < 0) | (i >= self._columns) | (j < 0) | (j >= self._rows)
        column, row = np.where(outside, 0, i).astype(np.int64), np.where(outside, 0, j).astype(np.int64)
        return np.where(outside, FARTHEST, self._field[row, column]).astype(np.float64)

    def between(self, x: Floats, y: Floats) -> Floats:
        """Return the distances of points, m, between those at the centres of the cells around them."""
        column, row = (x - self._x) / CELL, (y - self._y) / CELL
        i = np.clip(np.floor(column), 0, self._columns - 2).astype(np.int64)
        j = np.clip(np.floor(row), 0, self._rows - 2).astype(np.int64)
        share_x, share_y = np.clip(column - i, 0.0, 1.0), np.clip(row - j, 0.0, 1.0)
        field = self._field
        south = field[j, i] * (1.0 - share_x) + field[j, i + 1] * share_x
        north = field[j + 1, i] * (1.0 - share_x) + field[j + 1, i + 1] * share_x
        return np.asarray(south * (1.0 - share_y) + north * share_y)
