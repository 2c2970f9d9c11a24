"""Maps as grids."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapely.geometry import Point, Polygon

from intellwheels_agents.map_cells import RESOLUTION, solids
from intellwheels_agents.ros_gateway.floor_grid import OCCUPIED, floor_grid
from intellwheels_maps import floor
from intellwheels_schemas.messages import Corner, Map, Obstacle, Wall


def corners(*points: tuple[float, float]) -> tuple[Corner, ...]:
    return tuple(Corner(x=x, y=y) for x, y in points)


def test_square_of_a_metre_has_the_cells_of_a_metre() -> None:
    square = Wall(corner=corners((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))
    grid = floor_grid(Map(format="iw.v1", name="m", wall=(square,)), 0.1, 2.5)
    cells = grid.data.reshape(grid.info.height, grid.info.width)
    assert (grid.info.origin.position.x, grid.info.origin.position.y) == pytest.approx((-0.5, -0.5))
    # Edges on the border of two cells mark both.
    assert 100 <= np.count_nonzero(cells == OCCUPIED) <= 144
    assert (cells[5:15, 5:15] == OCCUPIED).all()
    assert (grid.header.frame_id, grid.header.stamp.sec) == ("map", 2)


def test_thin_wall_is_not_lost() -> None:
    wall = Wall(thickness=0.001, corner=corners((0.0, 0.003), (3.0, 2.003)))
    grid = floor_grid(Map(format="iw.v1", name="m", wall=(wall,)), 0.05, 0.0)
    cells = grid.data.reshape(grid.info.height, grid.info.width)
    columns = slice(10, 10 + 60)
    assert (cells[:, columns] == OCCUPIED).any(axis=0).all()


def test_what_is_overhead_is_free() -> None:
    shelf = Obstacle(name="shelf", bottom=1.8, top=2.0, corner=corners((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)))
    grid = floor_grid(Map(format="iw.v1", name="m", obstacle=(shelf,)), 0.1, 0.0)
    assert not grid.data.any()


def test_grid_of_the_ward_agrees_with_its_polygons() -> None:
    ward = floor("ward")
    grid = floor_grid(ward, RESOLUTION, 0.0)
    cells = grid.data.reshape(grid.info.height, grid.info.width)
    polygons = [Polygon(ring) for ring in solids(ward)]
    rng = np.random.default_rng(1)
    half = RESOLUTION * math.sqrt(0.5)
    for row, column in zip(rng.integers(0, cells.shape[0], 150), rng.integers(0, cells.shape[1], 150), strict=True):
        origin = grid.info.origin.position
        centre = Point(origin.x + (column + 0.5) * RESOLUTION, origin.y + (row + 0.5) * RESOLUTION)
        distance = min(polygon.distance(centre) for polygon in polygons)
        occupied = cells[row, column] == OCCUPIED
        assert occupied == (distance == 0.0) or distance <= half


def test_hole_of_a_ring_and_overlapping_solids() -> None:
    # A C: its opening is free, and a second solid over its back changes nothing.
    shape = corners((0.0, 0.0), (2.0, 0.0), (2.0, 0.5), (0.5, 0.5), (0.5, 1.5), (2.0, 1.5), (2.0, 2.0), (0.0, 2.0))
    back = corners((0.0, 0.0), (0.5, 0.0), (0.5, 2.0), (0.0, 2.0))
    walls = tuple(Wall(corner=one) for one in (shape, back))
    grid = floor_grid(Map(format="iw.v1", name="m", wall=walls), 0.1, 0.0)
    cells = grid.data.reshape(grid.info.height, grid.info.width)
    assert (cells[6:24, 6:9] == OCCUPIED).all()
    assert not cells[12:19, 12:25].any()


def test_empty_map_has_a_grid() -> None:
    grid = floor_grid(Map(format="iw.v1", name="m"), 0.05, 0.0)
    assert (grid.info.width, grid.info.height) == (20, 20)
