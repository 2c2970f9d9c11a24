"""Readings as messages of ROS: angles, ranges that are no numbers, units."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.ros_gateway.sensor_messages import (
    GRAVITY,
    JointStates,
    imu_message,
    laser_scan,
    range_message,
)
from intellwheels_maps import robot
from intellwheels_schemas.messages import EncodersReading, IMUReading, Lidar, LidarReading, ProximityReading

SIDE = Lidar(id="side", x=0.0, y=0.3, z=0.3, direction_deg=90.0, fov_deg=180.0, rays=3, min_range=0.1, max_range=4.0)


def test_angles_of_a_scan_count_from_the_axis_of_the_sensor() -> None:
    reading = LidarReading(
        id="side", start_deg=0.0, step_deg=90.0, ranges=(1.0, None, None), statuses=("ok", "none", "near")
    )
    scan = laser_scan("chair1/side", 12.345, SIDE, reading, 0.05)
    assert (scan.angle_min, scan.angle_max) == pytest.approx((-math.pi / 2.0, math.pi / 2.0))
    assert scan.angle_increment == pytest.approx(math.pi / 2.0)
    assert scan.ranges.tolist() == [1.0, math.inf, -math.inf]
    assert (scan.header.frame_id, scan.range_min, scan.range_max, scan.scan_time) == ("chair1/side", 0.1, 4.0, 0.05)


def test_failed_ray_is_no_number() -> None:
    reading = LidarReading(id="side", start_deg=0.0, step_deg=90.0, ranges=(None,), statuses=("fault",))
    assert math.isnan(laser_scan("f", 0.0, SIDE, reading, 0.05).ranges[0])


@pytest.mark.parametrize(("status", "value", "wanted"), [
    ("ok", 1.25, 1.25), ("none", None, math.inf), ("near", None, -math.inf),
])  # fmt: skip
def test_range_of_a_proximity_sensor(status: str, value: float | None, wanted: float) -> None:
    sensor = robot("intellwheels").proximity[0]
    reading = ProximityReading(id="front", value=value, status=status)  # type: ignore[arg-type]
    message = range_message("chair1/front", 1.0, sensor, reading)
    assert message.range == wanted
    assert (message.field_of_view, message.min_range, message.max_range) == (math.radians(30.0), 0.05, 4.0)


def test_imu_measures_gravity_and_no_orientation() -> None:
    imu = robot("lidar-chair").imu[0]
    message = imu_message("chair1/imu", 1.0, imu, IMUReading(id="imu", forward=0.2, left=0.1, turn_rate=0.3))
    assert message.orientation_covariance[0] == -1.0
    assert (message.linear_acceleration.x, message.linear_acceleration.y) == (0.2, 0.1)
    assert message.linear_acceleration.z == GRAVITY
    assert message.angular_velocity.z == 0.3
    assert message.linear_acceleration_covariance[0] == pytest.approx(imu.noise**2)
    assert message.angular_velocity_covariance[8] == pytest.approx(imu.turn_noise**2)


def test_a_turn_of_a_wheel_is_two_pi() -> None:
    chair = robot("intellwheels")
    joints = JointStates(chair, 0.05)
    joints.message(0.0, 0, EncodersReading(id="wheels", left=0, right=0))
    turn = EncodersReading(id="wheels", left=chair.encoder_ticks, right=-chair.encoder_ticks)
    message = joints.message(1.0, 20, turn)
    assert message.name == ["left_wheel", "right_wheel"]
    assert message.position.tolist() == pytest.approx([2.0 * math.pi, -2.0 * math.pi])
    assert message.velocity.tolist() == pytest.approx([2.0 * math.pi, -2.0 * math.pi])
