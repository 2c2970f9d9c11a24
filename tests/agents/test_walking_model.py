"""Directions and speeds of a pedestrian who walks east."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.footprint import MovingPoint
from intellwheels_agents.walking_model import QUEUE, RADIUS, direction, free_way, gap, queue_gap

WALL: list[MovingPoint] = [(2.0, y / 10.0, 0.0, 0.0) for y in range(-20, 21)]


def east(*points: MovingPoint) -> float:
    return math.degrees(direction(points, (), 0.0, 0.0, 1.34, 5.0))


def test_way_is_free_as_far_as_the_disc_does_not_touch() -> None:
    assert free_way([(2.0, 0.0, 0.0, 0.0)], 0.0, 1.0, 1.0, 5.0) == pytest.approx(2.0 - RADIUS)
    assert free_way([(2.0, 0.3, 0.0, 0.0), (-1.0, 0.0, 0.0, 0.0)], 0.0, 1.0, 1.0, 5.0) == 5.0


def test_way_behind_somebody_who_walks_as_fast_is_free_and_towards_an_oncoming_one_half() -> None:
    assert free_way([(1.0, 0.0, 1.34, 0.0)], 0.0, 1.0, 1.34, 5.0) == 5.0
    assert free_way([(2.0, 0.0, -1.0, 0.0)], 0.0, 1.0, 1.0, 5.0) == pytest.approx((2.0 - RADIUS) / 2.0)


def test_walker_leaves_a_near_object_but_may_pass_it() -> None:
    assert free_way([(0.25, 0.0, 0.0, 0.0)], 0.0, 1.0, 1.0, 5.0) == 0.0
    assert free_way([(0.05, 0.25, 0.0, 0.0)], 0.0, 1.0, 1.0, 5.0) == 5.0


def test_free_way_is_walked_straight_and_an_obstacle_passed_on_the_right() -> None:
    assert east() == 0.0
    assert east((2.0, 0.0, 0.0, 0.0)) < 0.0
    assert east((2.0, -0.1, 0.0, 0.0)) > 0.0


def test_chair_is_passed_with_more_room() -> None:
    beside: list[MovingPoint] = [(2.0, 0.4, -0.5, 0.0)]
    assert direction(beside, (), 0.0, 0.0, 1.34, 5.0) == 0.0
    assert direction(beside, beside, 0.0, 0.0, 1.34, 5.0) < 0.0


def test_gap_in_a_wall_is_found() -> None:
    opening = [point for point in WALL if not 0.3 < point[1] < 1.3]
    assert 10.0 < east(*opening) < 35.0


def test_gap_counts_from_the_front_to_what_is_in_the_strip() -> None:
    assert gap([(1.0, 0.2, 0.0, 0.0), (0.5, 0.4, 0.0, 0.0)], 0.0, 1.0, 0.175) == pytest.approx(0.825)
    assert gap([(0.1, 0.0, 0.0, 0.0)], 0.0, 1.0, 0.175) == 0.0
    assert math.isinf(gap([(-1.0, 0.0, 0.0, 0.0)], 0.0, 1.0, 0.175))


def test_who_is_nearer_to_a_passage_goes_first() -> None:
    door = (2.0, 0.0)
    assert queue_gap([(0.6, 0.5, 0.0, 0.0)], door) == pytest.approx(math.hypot(0.6, 0.5) - QUEUE)
    assert math.isinf(queue_gap([(-0.2, 0.5, 0.0, 0.0)], door))
    assert queue_gap([(0.4, 0.0, 0.0, 0.0)], door) == 0.0
