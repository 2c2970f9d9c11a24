"""A map as cells."""

from __future__ import annotations

import math
import random

from intellwheels_agents.map_cells import MOST_CELLS, MOST_ROWS, RESOLUTION, MapCells, fitting_size, map_cells, plan_of
from intellwheels_maps import floor, names
from intellwheels_schemas.messages import Corner, Grid, Map, Obstacle, Place, Wall
from tests.every_case import every_case


def drawn(*corners: tuple[float, float], **fields: float) -> Map:
    wall = Wall(corner=tuple(Corner(x=x, y=y) for x, y in corners), **fields)
    return Map(format="iw.v1", name="drawn", wall=(wall,))


def at(cells: MapCells, x: float, y: float) -> int:
    column, row = int((x - cells.west) / cells.size), int((y - cells.south) / cells.size)
    return cells.cells[row * cells.columns + column]


def test_inside_is_occupied_and_outside_is_free() -> None:
    cells = map_cells(drawn((0, 0), (2, 0), (2, 1), (0, 1)))
    assert at(cells, 1.0, 0.5) == at(cells, 0.01, 0.01) == 1
    assert at(cells, -0.2, 0.5) == at(cells, 1.0, 1.2) == 0
    assert len(cells.cells) == cells.columns * cells.rows


def test_a_wall_thinner_than_a_cell_is_not_lost() -> None:
    cells = map_cells(drawn((0, 0), (3, 1.1), thickness=0.001))
    assert all(at(cells, 3.0 * share, 1.1 * share) for share in (0.1, 0.33, 0.5, 0.77))


def test_a_triangle_covers_its_area() -> None:
    generator = random.Random(3)
    for _ in range(20):
        a, b, c = ((generator.uniform(0, 5), generator.uniform(0, 5)) for _ in range(3))
        cells = map_cells(drawn(a, b, c))
        area = abs((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])) / 2.0
        border = sum(math.dist(*pair) for pair in ((a, b), (b, c), (c, a)))
        found = sum(cells.cells) * cells.size**2
        # Each cell that the border passes may count as a whole.
        assert area - 0.05 * border - 0.05 <= found <= area + 2.0 * cells.size * border + 0.1


def test_what_is_above_a_person_is_left_out() -> None:
    corners = tuple(Corner(x=x, y=y) for x, y in ((0, 0), (1, 0), (1, 1)))
    lamp = Obstacle(name="lamp", bottom=1.9, top=2.2, corner=corners)
    assert sum(map_cells(Map(format="iw.v1", name="lamps", obstacle=(lamp,))).cells) == 0
    assert sum(map_cells(drawn((0, 0), (1, 0), (1, 1), bottom=1.9, height=2.5)).cells) == 0
    assert sum(map_cells(drawn((0, 0), (1, 0), (1, 1), bottom=1.4, height=2.5)).cells) > 0


def test_places_are_on_the_grid() -> None:
    place = Place(name="far", x=4.0, y=-3.0)
    cells = map_cells(Map(format="iw.v1", name="m", grid=Grid(position=(place,))), 0.5)
    assert (cells.west, cells.south, cells.columns, cells.rows) == (3.5, -3.5, 2, 2)


@every_case("name", names("floors"))
def test_every_included_map_has_cells(name: str) -> None:
    cells = map_cells(floor(name))
    assert 0 < sum(cells.cells) < cells.columns * cells.rows <= MOST_CELLS


def test_a_map_of_the_largest_size_has_larger_cells() -> None:
    far = 9_999.0
    spikes = [(-far + 300.0 * k, far if k % 2 else -far) for k in range(60)]
    cells = map_cells(drawn(*spikes, thickness=0.1))
    assert cells.columns * cells.rows <= MOST_CELLS
    assert cells.size > 1.0


def test_an_empty_map_has_free_cells() -> None:
    assert sum(map_cells(Map(format="iw.v1", name="empty")).cells) == 0


def test_a_large_map_gets_larger_cells() -> None:
    assert fitting_size(floor("ward")) == RESOLUTION
    assert fitting_size(drawn((0.0, 0.0), (200.0, 100.0), thickness=0.1)) == 0.2


def test_thousands_of_long_walls_are_no_burden() -> None:
    walls = tuple(
        Wall(thickness=0.02, corner=(Corner(x=0.0, y=index * 0.01), Corner(x=40.0, y=40.0 - index * 0.01)))
        for index in range(2000)
    )
    document = Map(format="iw.v1", name="m", wall=walls)
    assert plan_of(document, 0.1).cells > 400 * 400
    assert plan_of(document, 0.1).rows > 4 * MOST_ROWS
    cells = map_cells(document)
    assert plan_of(document, cells.size).rows <= MOST_ROWS
    assert any(cells.cells)


def test_the_size_that_is_asked_for_is_used() -> None:
    cells = map_cells(drawn((0, 0), (2, 0), (2, 1), (0, 1)), 0.25)
    assert (cells.size, cells.columns, cells.rows) == (0.25, 12, 8)
    assert plan_of(drawn((0, 0), (2, 0), (2, 1), (0, 1)), 0.25).cells == 96
