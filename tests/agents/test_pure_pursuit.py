"""A path is followed forwards only."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.pure_pursuit import Path

HOOK = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)]


def test_length_is_the_sum_of_the_legs_and_equal_neighbours_count_once() -> None:
    assert Path([*HOOK, (4.0, 3.0)]).length == 7.0


def test_fewer_than_two_points_are_refused() -> None:
    with pytest.raises(ValueError, match="at least 2 different points"):
        Path([(1.0, 1.0), (1.0, 1.0)])


def test_progress_never_goes_back() -> None:
    path = Path(HOOK)
    for x, done in ((0.5, 0.5), (1.2, 1.2), (0.7, 1.2)):
        path.update(x, 0.1)
        assert path.done == pytest.approx(done)


def test_path_that_returns_along_itself_is_not_cut_short() -> None:
    path = Path([(0.0, 0.0), (5.0, 0.0), (5.0, 0.1), (0.0, 0.1)])
    path.update(1.0, 0.1)
    assert path.remaining > 9.0


def test_point_ahead_follows_corners_and_extends_the_last_leg() -> None:
    path = Path(HOOK)
    path.update(1.0, 0.0)
    path.update(2.0, 0.0)
    path.update(3.0, 0.0)
    assert path.ahead(2.0) == pytest.approx((4.0, 1.0))
    assert path.ahead(5.0) == pytest.approx((4.0, 4.0))


def test_distance_to_the_next_sharp_corner_or_the_end() -> None:
    path = Path(HOOK)
    assert path.to_corner(math.radians(30.0)) == pytest.approx(4.0)
    assert path.to_corner(math.radians(100.0)) == pytest.approx(7.0)


def test_path_grows_at_its_end() -> None:
    path = Path([(0.0, 0.0), (1.0, 0.0)])
    path.extend((1.0, 0.0))
    assert path.length == 1.0
    path.extend((1.0, 2.0))
    assert (path.length, path.end) == (3.0, (1.0, 2.0))
    path.update(1.0, 0.0)
    path.update(1.0, 0.5)
    assert path.done == pytest.approx(1.5)
