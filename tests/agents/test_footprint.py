"""For how long a body may move before it comes too near to a point."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.footprint import Footprint, displacement
from intellwheels_agents.range_scan import Outline

BODY = Footprint(Outline(front=0.8, back=0.2, side=0.3))


def test_clearance_is_to_edge_or_corner_and_negative_inside() -> None:
    assert BODY.clearance(1.0, 0.1) == pytest.approx(0.2)
    assert BODY.clearance(1.1, 0.7) == pytest.approx(0.5)
    assert BODY.clearance(0.0, 0.0) == pytest.approx(-0.2)


def test_straight_motion_is_free_until_the_margin_remains() -> None:
    assert BODY.free([(1.8, 0.0)], 0.5, 0.0, 5.0, 0.1) == pytest.approx(1.8, abs=0.001)


def test_obstacle_beside_the_path_is_passed() -> None:
    assert BODY.free([(1.8, 0.41)], 0.5, 0.0, 5.0, 0.1) == 5.0


def test_turn_swings_the_corner_into_an_obstacle_beside() -> None:
    point = (0.5, 0.5)
    assert BODY.free([point], 0.0, 1.0, 1.0, 0.02) < 0.5
    assert BODY.free([point], 0.0, -0.3, 1.0, 0.02) == 1.0


def test_moving_point_reaches_a_standing_body() -> None:
    assert BODY.free_of_moving([(2.8, 0.0, -1.0, 0.0)], 0.0, 0.0, 5.0, 0.0) == pytest.approx(2.0, abs=0.04)
    assert BODY.free_of_moving([(2.8, 0.0, 0.5, 0.0)], 0.4, 0.0, 5.0, 0.0) == 5.0


def test_body_too_near_may_move_away_but_no_nearer() -> None:
    assert BODY.free([(0.82, 0.0)], -0.5, 0.0, 1.0, 0.1) == 1.0
    assert BODY.free([(0.82, 0.0)], 0.5, 0.0, 1.0, 0.1) == pytest.approx(0.0, abs=1e-4)


def test_quarter_of_a_circle_ends_at_its_radius() -> None:
    assert displacement(math.pi / 2.0, math.pi / 2.0) == pytest.approx((1.0, 1.0))
    assert displacement(2.0, 0.0) == (2.0, 0.0)
