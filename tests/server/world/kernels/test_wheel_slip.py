"""Blocked wheels roll on by the share that the robot declares."""

import math

import numpy as np
import pytest

from intellwheels_schemas.messages import Robot
from intellwheels_server.world.kernels.motor_model import motor_figures
from intellwheels_server.world.kernels.wheel_slip import (
    FLAW_ROWS,
    SLIP,
    rolled_while_blocked,
    rolled_while_stalled,
    slip_figures,
)
from tests.every_case import every_case


@pytest.mark.parametrize(("slip", "rolled"), [(0.0, (0.01, 0.0)), (0.25, (0.0325, 0.05)), (1.0, (0.1, 0.2))])
def test_wheels_roll_on_by_a_share_of_the_motion_denied(slip: float, rolled: tuple[float, float]) -> None:
    flaws = np.zeros((FLAW_ROWS, 1))
    flaws[SLIP:FLAW_ROWS, 0] = slip_figures(Robot(slip=slip), 0.05)
    assert rolled_while_blocked(flaws, 0, 0.1, 0.2, 0.01, 0.0, 7, 0.05) == pytest.approx(rolled, abs=1e-15)


@every_case("slip", [0.25, 1.0])
@every_case("period", [0.01, 0.02, 0.05, 0.1, 0.2])
def test_wheels_of_a_pressed_body_roll_by_time_and_not_by_ticks(slip: float, period: float) -> None:
    robot = Robot(slip=slip, top_speed=1.0, track=0.5, acceleration_curve=0.9)
    motors, flaws = np.array(motor_figures(robot, period)).reshape(-1, 1), np.zeros((FLAW_ROWS, 1))
    flaws[SLIP:FLAW_ROWS, 0] = slip_figures(robot, period)
    keys = np.zeros((2, 1), dtype=np.int64)
    left = right = way = turned = 0.0
    for tick in range(round(2.0 / period)):
        left, right, travel, turn = rolled_while_stalled(motors, flaws, keys, 0, left, right, 1.0, 0.5, tick, period)
        way, turned = way + travel, turned + turn
    tau = -0.05 / math.log(0.9)
    share = slip * (2.0 - tau * (1.0 - math.exp(-2.0 / tau)))
    assert (way, turned) == pytest.approx((0.75 * share, -0.5 * share / 0.5), abs=1e-12)
    # After a crash the wheels are no faster than their share, and without power they stop.
    assert rolled_while_stalled(motors, flaws, keys, 0, 1.0, 1.0, 0.5, 0.5, 0, period)[0] == pytest.approx(0.5 * slip)
    assert rolled_while_stalled(motors, flaws, keys, 0, 1.0, 1.0, 0.0, 0.0, 0, period) == (0.0, 0.0, 0.0, 0.0)


def test_wheels_without_slip_stop_with_the_body() -> None:
    robot = Robot(top_speed=1.0, acceleration_curve=0.9)
    motors, keys = np.array(motor_figures(robot, 0.05)).reshape(-1, 1), np.zeros((2, 1), dtype=np.int64)
    assert rolled_while_stalled(motors, np.zeros((FLAW_ROWS, 1)), keys, 0, 0.7, 0.8, 1.0, 1.0, 0, 0.05) == (0, 0, 0, 0)
