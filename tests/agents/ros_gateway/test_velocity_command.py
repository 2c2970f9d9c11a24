"""Velocities to motor powers, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import pytest

from intellwheels_agents.ros_gateway.velocity_command import TWIST, TWIST_STAMPED, VelocityCommand
from intellwheels_maps import robot
from intellwheels_schemas.errors import WireError
from tests.agents.ros_gateway.stand_in_node import twist, twist_stamped

CHAIR = robot("intellwheels")


def taken(message: Any, kind: str = TWIST, now: float = 10.0) -> VelocityCommand:
    command = VelocityCommand("chair1", CHAIR)
    command.take(kind, message, now)
    return command


def test_half_of_the_top_speed_is_half_of_the_power() -> None:
    assert taken(twist(0.5 * CHAIR.top_speed, 0.0)).powers(10.0) == (0.5, 0.5)


def test_a_turn_follows_from_the_track() -> None:
    left, right = taken(twist(0.0, 1.0)).powers(10.0)
    assert right == -left == pytest.approx(CHAIR.track / 2.0 / CHAIR.top_speed)


def test_too_fast_a_velocity_keeps_its_curvature() -> None:
    left, right = taken(twist(3.0, 3.0)).powers(10.0)
    assert right == 1.0
    assert (right - left) / CHAIR.track == pytest.approx((right + left) / 2.0)


def test_without_a_velocity_the_motors_are_off() -> None:
    assert VelocityCommand("chair1", CHAIR).powers(0.0) == (0.0, 0.0)


def test_dead_man_is_half_a_second_of_simulated_time() -> None:
    command = taken(twist(0.5, 0.0), now=10.0)
    assert command.powers(10.5)[0] > 0.0
    assert command.powers(10.55) == (0.0, 0.0)


def test_a_stamp_counts_from_when_it_was_made() -> None:
    command = taken(twist_stamped(0.5, 0.0, 9.7), TWIST_STAMPED, now=10.0)
    assert command.powers(10.2)[0] > 0.0
    assert command.powers(10.25) == (0.0, 0.0)
    assert taken(twist_stamped(0.5, 0.0, 0.0), TWIST_STAMPED, now=10.0).stamp == 10.0


@pytest.mark.parametrize(("kind", "message", "text"), [
    (TWIST, twist(math.nan, 0.0), "cmd_vel: expected finite numbers"),
    (TWIST, twist(0.0, math.inf), "cmd_vel: expected finite numbers"),
    (TWIST, twist(1e308, 1e308), "cmd_vel: expected at most 100 m/s and 1000 rad/s"),
    (TWIST_STAMPED, twist_stamped(0.5, 0.0, 9.0), "cmd_vel.header.stamp: expected simulated time within 0.5 s"),
    (TWIST_STAMPED, twist_stamped(0.5, 0.0, 1.7e9), "cmd_vel.header.stamp: expected simulated time"),
    (TWIST_STAMPED, twist_stamped(0.5, 0.0, 10.0, "map"), "cmd_vel.header.frame_id: expected chair1/base_link"),
])  # fmt: skip
def test_refused_velocity_changes_nothing(kind: str, message: Any, text: str) -> None:
    command = taken(twist(0.2, 0.0))
    before = command.powers(10.0)
    with pytest.raises(WireError) as caught:
        command.take(kind, message, 10.0)
    assert caught.value.text.startswith(text)
    assert command.powers(10.0) == before


def test_sideways_is_nothing_a_chair_can_do() -> None:
    sideways = twist(0.1, 0.0)
    sideways.linear.y = 0.1
    with pytest.raises(WireError, match=r"linear\.x and angular\.z only"):
        taken(sideways)
