"""Uniform grids: nothing that overlaps a cell is missing from it."""

import numpy as np

from intellwheels_server.world.kernels.grid import cell_of, fill_cells
from tests.every_case import every_case


@every_case(
    ("x", "cell"), [(-5.0, 0), (0.0, 0), (0.49, 0), (0.5, 1), (1.99, 3), (2.0, 3), (1e300, 3), (float("nan"), 0)]
)
def test_coordinates_outside_belong_to_the_cell_at_the_edge(x: float, cell: int) -> None:
    assert cell_of(x, 0.0, 0.5, 4) == cell


def test_each_cell_lists_the_boxes_that_overlap_it_ascending() -> None:
    rng = np.random.default_rng(1)
    low = rng.uniform(0.0, 9.0, (80, 2))
    boxes = np.hstack([low, low + rng.uniform(0.0, 2.0, (80, 2))])
    grid = fill_cells(boxes, 0.0, 0.0, 1.0, 11, 11)
    assert grid[:2].tolist() == [11, 11]
    for row in range(11):
        for column in range(11):
            at = 2 + row * 11 + column
            inside = (
                (boxes[:, 0] < column + 1) & (boxes[:, 2] >= column) & (boxes[:, 1] < row + 1) & (boxes[:, 3] >= row)
            )
            assert grid[grid[at] : grid[at + 1]].tolist() == np.nonzero(inside)[0].tolist()


def test_empty_grid_has_its_cells() -> None:
    assert fill_cells(np.empty((0, 4)), 0.0, 0.0, 1.0, 2, 1).tolist() == [2, 1, 5, 5, 5]
