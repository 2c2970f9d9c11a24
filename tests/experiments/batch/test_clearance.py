from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_experiments.batch.clearance import clearance, half_width, shortest_path
from intellwheels_maps import floor, robot


def test_clearance_is_to_the_nearest_wall_or_obstacle() -> None:
    chair, corridor = robot("intellwheels"), floor("corridor15m")
    # Beside block A, whose near side is at y -0.2, and in the middle of the corridor, 1.2 m to the walls.
    poses = np.array([[5.4, 0.4, 0.0], [2.0, 0.0, 0.0]])
    assert clearance(poses, chair, corridor, {}) == pytest.approx([0.6 - 0.33, 1.2 - 0.33])


def test_what_is_at_another_height_does_not_count() -> None:
    chair, lounge, table = robot("intellwheels"), floor("lounge"), robot("table")
    place = np.array([[4.5, 2.5, math.pi / 2.0]])
    beside = np.array([[3.0, 2.5, 0.0]])
    # The chair's base ends 0.696 m before its centre but is lower than the top; its upper body ends 0.3 m before it.
    found = clearance(beside, chair, lounge, {"table": (table, place)})
    legs = math.hypot(4.5 - 0.35 - 0.025 - 3.696, 0.75 - 0.025 - 0.33)
    assert found[0] == pytest.approx(min(legs, 4.1 - 3.3))


def test_body_that_is_not_there_does_not_count() -> None:
    nowhere = np.full((1, 3), math.nan)
    at = np.array([[2.0, 0.0, 0.0]])
    found = clearance(at, robot("intellwheels"), floor("corridor15m"), {"x": (robot("crate"), nowhere)})
    assert found == pytest.approx([0.87])


def test_shortest_path_is_straight_without_obstacles() -> None:
    assert shortest_path(floor("corridor15m"), (0.0, 0.0), (4.0, 0.0), 0.33) == pytest.approx(4.0)


def test_shortest_way_bends_round_the_blocks_at_the_bodys_half_width() -> None:
    # From the straight line it must leave by 0.13 m twice: once to the left of A, once to the right of B.
    found = shortest_path(floor("corridor15m"), (0.0, 0.0), (15.0, 0.0), 0.33)
    taut = math.hypot(5.0, 0.13) + 0.8 + math.hypot(4.2, 0.26) + 0.8 + math.hypot(4.2, 0.13)
    assert found == pytest.approx(taut, abs=0.005)


def test_body_wider_than_the_gap_has_no_path() -> None:
    assert shortest_path(floor("corridor15m"), (0.0, 0.0), (15.0, 0.0), 0.75) == math.inf


def test_half_width_is_to_the_wider_side() -> None:
    assert half_width(robot("intellwheels")) == pytest.approx(0.33)
