"""What was put into something may stay as deep, may leave, and is recorded."""

import numpy as np
import pytest

from intellwheels_server.world.kernels.allowed_penetration import deepest_overlap, record_overlaps
from intellwheels_server.world.kernels.arrays import HIT_BODY, HIT_DEPTH, HIT_NORMAL_X, HIT_OTHER, HIT_WALL, Shape
from intellwheels_server.world.kernels.penetration import A_WALL
from intellwheels_server.world.wall_pieces import Solid, walls_from
from tests.server.world.kernels.crowds import CHAIR, Floor

# The wall's face is the line x = 2.
WALL = walls_from([Solid([(2.0, -20.0), (3.0, -20.0), (3.0, 20.0), (2.0, 20.0)], 0.0, 2.5)])


def test_allowed_penetration_is_the_depth_when_put_and_ends_when_nothing_is_overlapped() -> None:
    floor = Floor([Shape("chair", CHAIR)], [(1.25, 0.0, 0.0)], WALL)
    floor.allow_overlap()
    assert floor.allowed[0] == pytest.approx(0.1)
    floor.drive(0, 0.05, 0.0)
    floor.tick()
    # Never deeper.
    assert floor.pose[0, 0] == pytest.approx(1.25, abs=1e-9)
    floor.drive(0, -0.06, 0.0)
    floor.tick()
    assert floor.pose[0, 0] == pytest.approx(1.19)
    assert floor.allowed[0] == pytest.approx(0.1)
    floor.tick()
    assert floor.allowed[0] == 0.0
    floor.drive(0, 0.06, 0.0)
    floor.tick()
    assert floor.pose[0, 0] == pytest.approx(1.15, abs=1e-9)


def test_within_its_allowed_penetration_a_body_may_move_both_ways() -> None:
    floor = Floor([Shape("chair", CHAIR)], [(1.25, 0.0, 0.0)], WALL)
    floor.allow_overlap()
    for travel, x in ((-0.04, 1.21), (0.03, 1.24), (0.03, 1.25)):
        floor.drive(0, travel, 0.0)
        floor.tick()
        assert floor.pose[0, 0] == pytest.approx(x, abs=1e-9)


def test_real_chair_put_into_another_is_recorded() -> None:
    floor = Floor(
        [Shape("real", CHAIR, externally_posed=True), Shape("virtual", CHAIR), Shape("far", CHAIR)],
        [(1.2, 0.0, 0.0), (0.1, 0.0, 0.0), (-9.0, 0.0, 0.0)],
        WALL,
    )
    hits, numbers = np.zeros((4, 6), dtype=np.int64), np.zeros((4, 6))
    who = np.array([0], dtype=np.int64)
    used = record_overlaps(floor.bodies, floor.walls, floor.pose, who, hits, numbers)
    assert hits[:used, [HIT_BODY, HIT_OTHER, HIT_WALL]].tolist() == [[0, A_WALL, 0], [0, 1, -1]]
    assert numbers[:used, HIT_DEPTH].tolist() == pytest.approx([0.05, 0.1])
    assert numbers[:used, HIT_NORMAL_X].tolist() == [-1.0, 1.0]


def test_deepest_overlap_is_that_of_walls_and_bodies() -> None:
    floor = Floor([Shape("a", CHAIR), Shape("b", CHAIR)], [(0.1, 0.0, 0.0), (1.2, 0.0, 0.0)], WALL)
    assert [deepest_overlap(floor.bodies, floor.walls, floor.pose, i) for i in range(2)] == pytest.approx([0.1, 0.1])
    floor.pose[0] = [-5.0, 0.0]
    assert [deepest_overlap(floor.bodies, floor.walls, floor.pose, i) for i in range(2)] == [0.0, 0.0]
