"""Cells hold one point each, and are found, replaced and dropped."""

from __future__ import annotations

import numpy as np
import pytest

from intellwheels_agents.navigation.point_cells import NEIGHBOURS, PointCells, cells_at


def put(cells: PointCells, places: list[tuple[float, float]], travel: float = 0.0) -> None:
    x, y = np.array(places).T
    cells.put(cells_at(x, y, 0.1), x, y, x, y, travel, tick=1)


def test_cells_on_both_sides_of_the_origin_have_eight_neighbours_each() -> None:
    x, y = np.meshgrid(np.arange(-2.5, 3.0), np.arange(-2.5, 3.0))
    cells = cells_at(x.ravel(), y.ravel(), 1.0).reshape(6, 6)
    assert len(set(cells.ravel().tolist())) == 36
    middle = int(cells[2, 2])
    assert {middle + step for step in NEIGHBOURS} == set(cells[1:4, 1:4].ravel().tolist()) - {middle}


def test_last_point_of_a_cell_is_kept() -> None:
    cells = PointCells()
    put(cells, [(0.01, 0.0), (0.02, 0.0), (0.5, 0.5)])
    put(cells, [(0.03, 0.0)], travel=2.0)
    assert cells.here().tolist() == [[0.03, 0.0], [0.5, 0.5]]
    assert cells.values[cells.TRAVEL].tolist() == [2.0, 0.0]


def test_dropped_cells_are_gone_at_once_and_can_come_back() -> None:
    cells = PointCells()
    put(cells, [(0.0, 0.0), (0.5, 0.5), (0.7, 0.7)])
    cells.drop(np.array([False, True, False]))
    assert cells.here().tolist() == [[0.0, 0.0], [0.7, 0.7]]
    assert len(cells.columns) == 2
    put(cells, [(0.5, 0.5)])
    cells.drop_dead()
    assert cells.here().tolist() == [[0.0, 0.0], [0.7, 0.7], [0.5, 0.5]]
    assert [cells.columns[cell] for cell in cells.cell.tolist()] == [0, 1, 2]
    cells.drop(np.ones(3, dtype=bool))
    cells.drop_dead()
    assert cells.here().shape == (0, 2)


@pytest.mark.parametrize("count", [1, 50])
def test_points_stay_with_their_cells(count: int) -> None:
    cells, generator = PointCells(), np.random.default_rng(count)
    for _ in range(20):
        put(cells, generator.uniform(-1.0, 1.0, (count, 2)).tolist())
        cells.drop(generator.random(len(cells.cell)) < 0.3)
        if generator.random() < 0.5:
            cells.drop_dead()
        x, y = cells.here().T
        assert sorted(cells_at(x, y, 0.1).tolist()) == sorted(cells.columns)
        assert all(int(cells.cell[column]) == cell for cell, column in cells.columns.items())
