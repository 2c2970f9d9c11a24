"""The speed of a real body is steady although its poses come none, one or two a tick."""

import math

import pytest

from intellwheels_schemas.messages import Entity
from intellwheels_viewer.reported_speed import WINDOW, ReportedSpeeds

TICK = 0.05
ADVANCE = 0.02  # metres a tick at 0.4 m/s


def driven(poses: list[int], speeds: ReportedSpeeds) -> list[float]:
    """Return the speeds of a chair that drives 0.4 m/s west and reports so many new poses at each tick."""
    x, found = 0.0, []
    for tick, new in enumerate(poses):
        x -= ADVANCE * new
        state = Entity(name="real1", x=x, y=0.0, heading=math.pi, speed=ADVANCE * new / TICK)
        found.append(speeds.smoothed(state, tick * TICK).speed)
    return found


def test_poses_that_come_none_one_or_two_a_tick_have_one_speed() -> None:
    found = driven([1] * 20 + [0, 2, 1, 0, 2, 0, 2, 1, 1] * 8, ReportedSpeeds())
    assert found[20:] == pytest.approx([0.4] * len(found[20:]), abs=1.01 * ADVANCE / WINDOW)


def test_a_chair_that_stands_has_no_speed_after_the_window() -> None:
    found = driven([1] * 20 + [0] * 21, ReportedSpeeds())
    assert found[-1] == pytest.approx(0.0, abs=1e-9)


def test_turning_on_the_spot_is_a_turn_rate_across_half_a_turn() -> None:
    speeds = ReportedSpeeds()
    for tick in range(30):
        heading = math.remainder(3.0 + 0.05 * tick, math.tau)
        last = speeds.smoothed(Entity(name="real1", x=1.0, y=1.0, heading=heading, turn_rate=9.0), tick * TICK)
    assert (last.speed, last.turn_rate) == pytest.approx((0.0, 1.0))


def test_the_first_state_and_one_after_a_gap_are_as_they_come() -> None:
    speeds = ReportedSpeeds()
    here = Entity(name="real1", x=1.0, y=1.0, heading=0.0, speed=0.3)
    far = Entity(name="real1", x=9.0, y=1.0, heading=0.0, speed=0.4)
    assert speeds.smoothed(here, 0.0) == here
    assert speeds.smoothed(far, 60.0) == far
    speeds.clear()
    assert speeds.smoothed(here, 60.05) == here


def test_a_body_that_is_shown_twice_at_one_tick_counts_once() -> None:
    speeds = ReportedSpeeds()
    for tick in (0, 1, 2, 2, 2, 3):
        last = speeds.smoothed(Entity(name="real1", x=ADVANCE * tick, y=0.0, heading=0.0), tick * TICK)
    assert last.speed == pytest.approx(0.4)
