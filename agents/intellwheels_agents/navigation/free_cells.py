"""When each cell of a grid around a body was last seen free.

The cells lie on a torus: those that are `SIDE` cells apart share a place, which belongs to the one that was seen last.
A body that comes back to the other one finds that it was never seen. So nothing has to be cleared away.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from intellwheels_agents.navigation.point_cells import ROW, Cells, Floats

SIDE: Final = 512
"""Cells along a side of the torus, a power of two: 10 m at 2 cm. A body sees 2 m around, and forgets within seconds."""


class FreeCells:
    """The times of the cells."""

    def __init__(self) -> None:
        self._cell: Cells = np.zeros(SIDE * SIDE, dtype=np.int64)
        self._time: Floats = np.full(SIDE * SIDE, -math.inf)

    def note(self, cells: Cells, time: float) -> None:
        """Note that cells were seen free at a time, s."""
        places = _places(cells)
        self._cell[places] = cells
        self._time[places] = time

    def times(self, cells: Cells) -> Floats:
        """Return when cells were last seen free, s; minus infinity for never."""
        places = _places(cells)
        return np.where(self._cell[places] == cells, self._time[places], -math.inf)

    def forget(self, cells: Cells) -> None:
        """Forget that cells were seen free."""
        places = _places(cells)
        self._time[places[self._cell[places] == cells]] = -math.inf


def _places(cells: Cells) -> Cells:
    # A cell is its column times `ROW`, plus its row, which may be negative.
    return ((cells + ROW // 2) // ROW % SIDE) * SIDE + cells % SIDE
