"""Whom a pedestrian likes attracts it, whom it fears repels it; positions and velocities by hand."""

from __future__ import annotations

import pytest

from intellwheels_agents.feelings import MOST, NEAR, RISE, SHY, TORN, felt, nearest, pull, push

OWN = (1.0, 2.0)


def test_attraction_grows_from_near_to_its_full_strength() -> None:
    distances = (0.0, NEAR, NEAR + RISE / 2.0, NEAR + RISE, 50.0)
    assert [pull(OWN, (1.0 + metres, 2.0)) for metres in distances] == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0])


def test_repulsion_falls_with_distance_and_ends() -> None:
    assert [push(OWN, (1.0, 2.0 - metres)) for metres in (0.0, SHY / 2.0, SHY, 50.0)] == [MOST, MOST / 2.0, 0.0, 0.0]


def test_the_nearest_is_followed() -> None:
    assert nearest(OWN, [(9.0, 2.0), (1.0, 4.0)]) == (1.0, 4.0)
    assert nearest(OWN, []) is None


def test_liked_one_bends_the_way_to_the_goal_and_feared_one_turns_back() -> None:
    east = (0.6, 0.0)
    assert felt(OWN, east, 1.2, [(1.0, 9.0)], []) == pytest.approx((0.6, TORN * 1.2))
    assert felt(OWN, east, 1.2, [], [(1.0 + SHY / 4.0, 2.0)]) == pytest.approx((-1.2, 0.0))
    assert felt(OWN, east, 1.2, [], [(1.0 + SHY, 2.0)]) == pytest.approx(east)


def test_nobody_runs_for_love_or_fear_and_the_same_place_has_no_direction() -> None:
    x, y = felt(OWN, (1.2, 0.0), 1.2, [(30.0, 2.0)], [(1.0, 2.1), OWN])
    assert x * x + y * y == pytest.approx(1.2 * 1.2)
