from __future__ import annotations

import math

import pytest

from intellwheels_viewer.head_turn import DOWN, HELD, Eye, HeadTurn, eye_of, line_of_sight, position_of
from tests.viewer.drawings.cast import entity, robot


def test_the_eye_is_over_the_seat_at_the_height_that_the_user_has() -> None:
    eye = eye_of(robot("rear-wheel"), 1.3, 70.0)
    assert eye == pytest.approx((0.12, 1.3, math.radians(70.0)))
    assert tuple(position_of(entity("a", 2.0, 3.0, math.pi / 2), eye)) == pytest.approx((2.0, 3.12, 1.3))
    assert eye_of(robot("person")).ahead == pytest.approx(0.0)


def test_a_head_that_is_straight_looks_ahead_and_down_to_the_knees() -> None:
    assert line_of_sight(0.0, 0.0, 0.0) == pytest.approx((math.cos(DOWN), 0.0, -math.sin(DOWN)))
    assert line_of_sight(0.0, math.pi / 2, DOWN) == pytest.approx((0.0, 1.0, 0.0))


def test_the_mouse_turns_the_head_which_then_comes_back() -> None:
    head = HeadTurn()
    head.turn_to(line_of_sight(1.0, 0.5, 0.2), 1.0, 10.0)
    assert (head.yaw, head.pitch) == pytest.approx((0.5, 0.2))
    head.come_back(10.0 + HELD - 0.01)
    assert head.yaw == pytest.approx(0.5), "it is still held"
    head.come_back(10.0 + HELD + 0.35)
    assert 0.1 < head.yaw < 0.3
    for step in range(1, 100):
        head.come_back(12.0 + 0.05 * step)
    assert (head.yaw, head.pitch, head.is_turned) == (0.0, 0.0, False)


def test_a_look_straight_up_says_nothing_about_the_heading() -> None:
    head = HeadTurn()
    head.turn_to(line_of_sight(0.0, 0.0, 0.0) * 0.0, 0.0, 1.0)
    assert not head.is_turned
    head.turn_to(line_of_sight(3.0, 0.3, 0.0), 3.0, 1.0)
    assert head.yaw == pytest.approx(0.3)
    head.straighten()
    assert Eye().height == 1.2
    assert not head.is_turned
