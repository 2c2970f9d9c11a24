"""The outlines of cells have the area of the cells, and simpler ones keep every cell on its side."""

from __future__ import annotations

import random

import numpy as np
import shapely

from intellwheels_maps.importers.cell_outlines import TOLERANCE, cell_area, count_corners, simplified
from tests.every_case import every_case


def cells(seed: int) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    """Return boxes, slanted strips and single cells."""
    draw = random.Random(seed)
    found = np.zeros((40, 60), dtype=bool)
    for _ in range(6):
        row, column = draw.randrange(35), draw.randrange(50)
        found[row : row + draw.randrange(1, 9), column : column + draw.randrange(1, 15)] = True
    slope = draw.uniform(-0.6, 0.6)
    for column in range(60):
        row = int(20 + slope * (column - 30))
        found[row : row + 2, column] = True
    for _ in range(15):
        found[draw.randrange(40), draw.randrange(60)] ^= True
    return found


@every_case("seed", range(30))
def test_area_is_the_number_of_cells_and_no_cell_changes_its_side(seed: int) -> None:
    walls = cells(seed)
    area = cell_area(walls)
    assert area.area == np.count_nonzero(walls)
    simple = simplified(area)
    assert simple.is_valid
    assert shapely.hausdorff_distance(area.boundary, simple.boundary, 0.05) <= TOLERANCE + 1e-9
    x, y = np.meshgrid(np.arange(60) + 0.5, np.arange(40) + 0.5)
    assert np.array_equal(shapely.contains_xy(simple, x, y), walls)
    assert len(shapely.get_coordinates(simple)) < len(shapely.get_coordinates(area))


@every_case("seed", range(10))
def test_corners_are_counted_before_anything_is_built(seed: int) -> None:
    walls = cells(seed)
    area = cell_area(walls)
    rings = [ring for part in shapely.get_parts(area) for ring in (part.exterior, *part.interiors)]
    # Cells that touch at a corner have two corners there.
    assert count_corners(walls) == sum(len(shapely.get_coordinates(shapely.simplify(ring, 0.0))) - 1 for ring in rings)


def test_no_cells_have_no_area() -> None:
    assert cell_area(np.zeros((3, 4), dtype=bool)).is_empty
    assert count_corners(np.zeros((3, 4), dtype=bool)) == 0
