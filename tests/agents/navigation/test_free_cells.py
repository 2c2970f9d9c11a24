"""Cells that were seen free, with their times."""

from __future__ import annotations

import math

import numpy as np

from intellwheels_agents.navigation.free_cells import SIDE, FreeCells
from intellwheels_agents.navigation.point_cells import cells_at

CELL = 0.02


def at(*points: tuple[float, float]) -> np.ndarray:
    x, y = np.array(points).T
    return cells_at(x, y, CELL)


def test_each_cell_has_the_time_at_which_it_was_last_seen() -> None:
    free = FreeCells()
    free.note(at((0.0, 0.0), (-1.0, -2.0), (3.0, -0.01)), 1.5)
    free.note(at((-1.0, -2.0)), 2.0)
    assert free.times(at((0.01, 0.01), (-1.0, -2.0), (3.0, -0.01), (3.0, 0.01))).tolist() == [1.5, 2.0, 1.5, -math.inf]


def test_cells_are_told_apart_all_over_the_torus() -> None:
    x, y = np.meshgrid(np.arange(SIDE, dtype=np.float64), np.arange(SIDE, dtype=np.float64))
    cells = cells_at((x.ravel() - 300.5) * CELL, (y.ravel() - 40.5) * CELL, CELL)
    free = FreeCells()
    for part, time in ((cells[::2], 1.0), (cells[1::2], 2.0)):
        free.note(part, time)
    assert (free.times(cells[::2]) == 1.0).all()
    assert (free.times(cells[1::2]) == 2.0).all()


def test_of_two_cells_at_one_place_the_last_seen_counts() -> None:
    free = FreeCells()
    near, far = at((0.5, 0.5)), at((0.5 + SIDE * CELL, 0.5))
    free.note(near, 1.0)
    free.note(far, 2.0)
    assert free.times(near).tolist() == [-math.inf]
    assert free.times(far).tolist() == [2.0]
    free.forget(near)
    assert free.times(far).tolist() == [2.0]


def test_what_is_forgotten_was_never_seen() -> None:
    free = FreeCells()
    cells = at((0.5, 0.5), (-0.5, 0.5))
    free.note(cells, 1.0)
    free.forget(cells[:1])
    assert free.times(cells).tolist() == [-math.inf, 1.0]
