"""Inertial units: change of speed, centripetal acceleration and turn rate."""

from __future__ import annotations

import numpy as np
import pytest

from intellwheels_schemas.file_records import Join
from intellwheels_schemas.messages import IMU, IMUReading
from intellwheels_server.world import State, measures
from tests.server.worlds import cart, do, run, world


def _read(state: State, at: int = 0) -> IMUReading:
    sensors = measures(state, "a").sensors
    assert sensors is not None
    return sensors.imu[at]


def test_acceleration_is_the_change_of_speed_over_the_tick() -> None:
    state = world({"a": cart(acceleration_limit=2.0, imu=(IMU(id="i"),))})
    assert (_read(state).forward, _read(state).left, _read(state).turn_rate) == (0.0, 0.0, 0.0)
    state, _ = run(state, 2, {"a": (1.0, 1.0)})
    assert _read(state).forward == pytest.approx(2.0, abs=1e-9)
    state, _, _ = do(state, Join(agent="b", robot=cart(9.0)))
    assert _read(state).forward == pytest.approx(2.0, abs=1e-9)
    state, _ = run(state, 20, {"a": (1.0, 1.0)})
    assert _read(state).forward == pytest.approx(0.0, abs=1e-9)


def test_turning_pulls_to_the_inside() -> None:
    state, _ = run(world({"a": cart(imu=(IMU(id="i"),))}), 3, {"a": (0.5, 1.0)})
    # 0.75 m/s on a track of 0.5 m: 1 rad/s to the left.
    assert (_read(state).left, _read(state).turn_rate) == pytest.approx((0.75, 1.0), abs=1e-9)


def test_noise_of_the_three_values_is_independent() -> None:
    state = world({"a": cart(imu=tuple(IMU(id=f"i{k}", noise=0.2, turn_noise=0.05) for k in range(60)))})
    found = []
    for _ in range(20):
        ones = [_read(state, k) for k in range(60)]
        found += [(one.forward, one.left, one.turn_rate) for one in ones]
        state, _ = run(state, 1)
    # Four standard errors of 1200 draws.
    assert np.std(found, axis=0) == pytest.approx([0.2, 0.2, 0.05], rel=0.085)
    assert np.abs(np.corrcoef(np.array(found).T) - np.eye(3)).max() < 4 / np.sqrt(1200)


def test_steps_and_walking_biases() -> None:
    robot = cart(imu=(IMU(id="s", step=0.5, turn_step=0.3), IMU(id="w", walk=1.0, turn_walk=0.1)))
    state, _ = run(world({"a": robot}), 3, {"a": (0.5, 1.0)})
    assert (_read(state).left, _read(state).turn_rate) == pytest.approx((1.0, 0.9), abs=1e-12)
    walked = _read(state, 1)
    assert walked.turn_rate != 1.0


def test_each_of_the_three_values_has_its_own_bias() -> None:
    count, ticks = 400, 20
    units = tuple(IMU(id=f"w{k}", walk=0.3, turn_walk=0.05) for k in range(count))
    state, _ = run(world({"a": cart(imu=units)}), ticks)
    sensors = measures(state, "a").sensors
    assert sensors is not None
    found = np.array([(one.forward, one.left, one.turn_rate) for one in sensors.imu])
    # One second: the declared deviations, within four standard errors, and no common cause.
    assert found.std(axis=0) == pytest.approx([0.3, 0.3, 0.05], rel=4 / np.sqrt(2 * count))
    assert np.abs(np.corrcoef(found.T) - np.eye(3)).max() < 4 / np.sqrt(count)
