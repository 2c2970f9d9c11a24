"""Where a pedestrian aims at a doorway, and when he would walk into others."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.doorway_queue import AIM_BEFORE, AIM_BEHIND, CIRCLE, Seen, aim, time_to_collision
from intellwheels_agents.doorways import WIDEST, Doorway, doorways
from tests.agents.person_trials import two_rooms


def seen(x: float, y: float, vx: float = 0.0, vy: float = 0.0) -> Seen:
    return Seen(x, y, vx, vy, math.hypot(x, y), math.atan2(y, x))


@pytest.mark.parametrize(
    ("x", "y", "ahead"),
    [(-2.0, 0.0, AIM_BEHIND), (-1.0, 1.0, -AIM_BEFORE), (-0.2, 0.25, AIM_BEHIND), (-0.2, 0.4, -AIM_BEFORE)],
)
def test_it_walks_before_the_doorway_until_it_can_pass_straight_on(x: float, y: float, ahead: float) -> None:
    ((door,), _) = doorways(two_rooms(0.9))
    assert aim(door, x, y) == (ahead, 0.0)


def test_it_walks_through_the_part_of_a_wide_doorway_that_is_ahead() -> None:
    door = Doorway(0.0, 0.0, 1.0, 0.0, WIDEST + 1.0, ())
    aims = [aim(door, -2.0, y) for y in (0.3, -0.7, 2.0)]
    assert [x for x, _ in aims] == [AIM_BEHIND, AIM_BEHIND, -AIM_BEFORE]
    assert [y for _, y in aims] == pytest.approx([0.3, -0.5, 0.5])


@pytest.mark.parametrize(
    ("other", "seconds"),
    [
        (seen(2.0, 0.0), 2.0 - CIRCLE),
        (seen(2.0, 0.0, -1.0), (2.0 - CIRCLE) / 2.0),
        (seen(2.0, 0.0, 1.0), 9.0),
        (seen(2.0, 0.5), 9.0),
        (seen(-1.0, 0.0), 9.0),
        (seen(0.2, 0.0), 0.0),
        (seen(0.05, 0.28), 9.0),
    ],
)
def test_time_to_collision_at_one_metre_a_second(other: Seen, seconds: float) -> None:
    assert time_to_collision([other], 1.0, 0.0, 9.0, 0.27) == pytest.approx(seconds)
