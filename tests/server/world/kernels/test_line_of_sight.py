"""Lines of sight and rays to walls."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from intellwheels_server.world.kernels.arrays import Shape, bodies_from
from intellwheels_server.world.kernels.line_of_sight import in_sight, ray_to_polygon
from intellwheels_server.world.kernels.spatial_query import place_boxes
from intellwheels_server.world.wall_pieces import Line, Solid, walls_from
from tests.server.world.kernels.crowds import LEAF, TABLE

SIGHT: Any = in_sight
BODIES = bodies_from([Shape("leaf", LEAF), Shape("table", TABLE)])
WALLS = walls_from(
    [Solid([(5.0, -1.0), (6.0, -1.0), (5.5, 1.0)], 0.0, 1.0), Line([(8.0, -5.0), (8.0, 5.0)], 0.2, 0.5, 2.0)]
)


def _sees(x: float, y: float, to_x: float, to_y: float, z: float = 0.4, opaque: tuple[int, int] = (1, 1)) -> bool:
    boxes, _ = place_boxes(np.array([[2.0, 3.0], [0.5, 0.0], [math.pi / 2, 0.0]]), BODIES.parts, BODIES.part_start)
    return bool(SIGHT(x, y, z, to_x, to_y, boxes, BODIES.part_start, np.array(opaque), *WALLS))


def test_ray_enters_a_polygon_through_the_edge_that_it_meets() -> None:
    first, end, _ = WALLS.links[0]
    way, edge = ray_to_polygon(WALLS.edges, first, end, 0.0, 0.0, 1.0, 0.0)
    assert way == pytest.approx(5.25, abs=1e-12)
    assert WALLS.edges[edge, 2] < 0.0
    assert ray_to_polygon(WALLS.edges, first, end, 5.5, 0.0, 1.0, 0.0) == (0.0, -1)
    assert ray_to_polygon(WALLS.edges, first, end, 7.0, 0.0, 1.0, 0.0)[0] == math.inf
    assert ray_to_polygon(WALLS.edges, first, end, 0.0, 2.0, 1.0, 0.0)[0] == math.inf
    assert ray_to_polygon(WALLS.edges, first, end, 0.0, -1.5, 1.0, 0.0)[0] == math.inf


def test_wall_hides_what_is_behind_it_at_its_heights() -> None:
    assert not _sees(4.0, 0.0, 7.0, 0.0)
    assert _sees(4.0, 0.0, 7.0, 0.0, z=1.0)
    assert _sees(7.0, 0.0, 9.0, 0.0)
    assert not _sees(7.0, 0.0, 9.0, 0.0, z=0.5)
    assert not _sees(9.0, 0.0, 7.0, 0.0, z=0.5)


def test_place_on_a_face_is_seen_and_what_is_nowhere_else_too() -> None:
    assert _sees(7.0, 0.0, 7.9, 0.0, z=0.5)
    assert _sees(1.0, 1.0, 1.0, 1.0)


def test_body_hides_unless_it_is_told_not_to() -> None:
    assert not _sees(1.0, 0.0, 4.0, 0.0)
    assert not _sees(1.0, 0.3, 4.0, -0.3)
    assert _sees(1.0, 0.0, 4.0, 0.0, opaque=(0, 1))
    assert not _sees(1.0, 0.0, 4.0, 0.0, z=0.7, opaque=(0, 1))
    assert _sees(1.0, 0.0, 4.0, 0.0, z=0.7, opaque=(0, 0))
