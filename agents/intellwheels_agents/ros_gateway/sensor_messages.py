"""Readings of sensors as messages of ROS. Pure.

A range that is too near is -inf, one of nothing inf, one of a failed sample nan.

Source:
    REP 117 for ranges that are no numbers; REP 145 for the IMU: an accelerometer at rest measures gravity upwards.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Final

from intellwheels_agents.ros_gateway.ros_messages import doubles, floats, header, matrix, quaternion, vector
from intellwheels_agents.ros_gateway.ros_names import WHEELS
from intellwheels_agents.ros_gateway.ros_types import made_of
from intellwheels_schemas.messages import (
    IMU,
    EncodersReading,
    IMUReading,
    Lidar,
    LidarReading,
    Proximity,
    ProximityReading,
    Robot,
)

GRAVITY: Final = 9.80665
"""Standard gravity, m/s2."""
UNMEASURED: Final = 1e-6
"""Variance of what the floor holds at 0, such as a roll rate."""
_INFRARED: Final = 1
_ULTRASOUND: Final = 0
_NO_RANGE: Final = {"none": math.inf, "near": -math.inf, "fault": math.nan}


def laser_scan(frame: str, seconds: float, lidar: Lidar, reading: LidarReading, period: float) -> Any:
    """Return a `sensor_msgs/LaserScan`; angles count anticlockwise from the sensor's axis.

    Args:
        frame: The sensor's frame.
        seconds: Simulated time of the scan.
        lidar: The sensor.
        reading: Its scan.
        period: Seconds of a tick.
    """
    first = math.radians(reading.start_deg - lidar.direction_deg)
    step = math.radians(reading.step_deg)
    return made_of("sensor_msgs/msg/LaserScan")(
        header=header(frame, seconds),
        angle_min=first,
        angle_max=first + step * (len(reading.ranges) - 1),
        angle_increment=step,
        time_increment=0.0,
        scan_time=lidar.every * period,
        range_min=lidar.min_range,
        range_max=lidar.max_range,
        ranges=floats(_ranges(reading)),
        intensities=floats(()),
    )


def _ranges(reading: LidarReading) -> Iterable[float]:
    for value, status in zip(reading.ranges, reading.statuses, strict=False):
        yield _NO_RANGE.get(status, math.nan) if value is None else value


def range_message(frame: str, seconds: float, sensor: Proximity, reading: ProximityReading) -> Any:
    """Return a `sensor_msgs/Range`."""
    value = reading.value
    return made_of("sensor_msgs/msg/Range")(
        header=header(frame, seconds),
        radiation_type=_INFRARED if sensor.model == "infrared" else _ULTRASOUND,
        field_of_view=math.radians(sensor.cone_deg),
        min_range=sensor.min_range,
        max_range=sensor.max_range,
        range=_NO_RANGE.get(reading.status, math.nan) if value is None else value,
        variance=0.0,
    )


def imu_message(frame: str, seconds: float, imu: IMU, reading: IMUReading) -> Any:
    """Return a `sensor_msgs/Imu` without an orientation, which it does not measure."""
    noise = max(imu.noise * imu.noise, UNMEASURED)
    return made_of("sensor_msgs/msg/Imu")(
        header=header(frame, seconds),
        orientation=quaternion(0.0),
        orientation_covariance=matrix(3, {(0, 0): -1.0}),
        angular_velocity=vector(z=reading.turn_rate),
        angular_velocity_covariance=matrix(3, {(2, 2): max(imu.turn_noise * imu.turn_noise, UNMEASURED)}, UNMEASURED),
        linear_acceleration=vector(reading.forward, reading.left, GRAVITY),
        linear_acceleration_covariance=matrix(3, {(0, 0): noise, (1, 1): noise}, UNMEASURED),
    )


class JointStates:
    """The turns of the driven wheels, from the encoders of one run."""

    def __init__(self, robot: Robot, period: float) -> None:
        """Take a robot and the seconds of a tick."""
        self._turn = 2.0 * math.pi / robot.encoder_ticks
        self._period = period
        self._last: tuple[int, float, float] | None = None

    def message(self, seconds: float, tick: int, reading: EncodersReading) -> Any:
        """Return a `sensor_msgs/JointState`: rad, and rad/s since the last reading."""
        left, right = reading.left * self._turn, reading.right * self._turn
        last_tick, last_left, last_right = self._last or (tick, left, right)
        span = (tick - last_tick) * self._period
        rates = ((left - last_left) / span, (right - last_right) / span) if span > 0.0 else (0.0, 0.0)
        self._last = tick, left, right
        return made_of("sensor_msgs/msg/JointState")(
            header=header("", seconds),
            name=list(WHEELS),
            position=doubles((left, right)),
            velocity=doubles(rates),
            effort=doubles(()),
        )
