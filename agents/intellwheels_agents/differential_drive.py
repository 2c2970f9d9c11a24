"""Differential drive, as a chair's controller sees it: speeds to motor powers, encoders and compass to a pose.

With v the forward speed (m/s), w the turn rate (rad/s, anticlockwise) and b the track (m):

    left = v - w b / 2,  right = v + w b / 2,  power = wheel speed / top speed

A pose here is an estimate. The true pose is known to the simulator only.
"""

from __future__ import annotations

import math

from intellwheels_agents.portable_math import sin, sincos
from intellwheels_schemas.messages import OdometryReading, Position, Robot, Sensors


def wrapped(angle: float) -> float:
    """Return the angle in (-pi, pi]."""
    wrapped_angle = math.remainder(angle, 2.0 * math.pi)
    return math.pi if wrapped_angle == -math.pi else wrapped_angle


def powers(robot: Robot, speed: float, turn_rate: float) -> tuple[float, float]:
    """Return the left and right motor powers, both in [-1, 1], for a speed and a turn rate.

    If a wheel cannot turn that fast, both are scaled down, which keeps the curvature.

    Args:
        robot: Gives the track and the top speed.
        speed: Forward, in m/s.
        turn_rate: Anticlockwise, in rad/s.
    """
    if robot.top_speed <= 0.0:
        return 0.0, 0.0
    half = turn_rate * robot.track / 2.0
    left, right = (speed - half) / robot.top_speed, (speed + half) / robot.top_speed
    largest = max(1.0, abs(left), abs(right))
    return left / largest, right / largest


class Odometry:
    """A pose estimate from encoders, with the heading corrected by a compass.

    Attributes:
        x, y: Metres, in the map's frame.
        heading: Radians, in (-pi, pi].
        turned: Radians turned since the start, not wrapped.
        tick: Tick of the reading behind the pose, if it came late; otherwise None.
    """

    def __init__(self, robot: Robot, start: Position, compass_share: float = 0.05) -> None:
        """Start at a pose.

        Args:
            robot: Gives the track, the wheel diameter and the encoder ticks per turn.
            start: The pose before the first reading.
            compass_share: Gain k of the complementary filter, in [0, 1]: the share of the difference to the compass
                that is taken over each tick. The heading from encoders is accurate from tick to tick but drifts over
                minutes; the compass is noisy at every tick but never drifts. A gain k keeps sqrt(k / (2 - k)) of the
                noise, 0.16 for k = 0.05, and corrects a drift within about 1 / k ticks.
        """
        self.x = start.x
        self.y = start.y
        self.heading = wrapped(start.heading)
        self.turned = 0.0
        self.tick: int | None = None
        self._start = start
        self._compass_share = compass_share
        self._track = robot.track
        self._metres_per_tick = math.pi * robot.wheel_diameter / robot.encoder_ticks
        self._last: tuple[int, int] | None = None

    def update(self, sensors: Sensors | None) -> None:
        """Update with the readings of a tick; absent readings change nothing.

        An odometry sensor takes precedence over encoders and compass. It measures the pose since joining; for a real
        chair that is the calibrated or corrected pose from its bridge, which is better than the raw encoder counts.
        """
        if sensors is None:
            return
        if sensors.odometry:
            self.tick = sensors.odometry[0].tick
            self._take_odometry(sensors.odometry[0])
            return
        if sensors.encoders:
            reading = sensors.encoders[0]
            self.tick = reading.tick
            # The body may have joined, and counted, long before this mind: the first reading is the reference.
            last_left, last_right = self._last or (reading.left, reading.right)
            self._move(
                (reading.left - last_left) * self._metres_per_tick, (reading.right - last_right) * self._metres_per_tick
            )
            self._last = (reading.left, reading.right)
        if sensors.compass:
            value = sensors.compass[0].value
            if value is not None:
                self.heading = wrapped(self.heading + self._compass_share * wrapped(value - self.heading))

    def _take_odometry(self, reading: OdometryReading) -> None:
        """Take over a pose relative to the start."""
        start = self._start
        s, c = sincos(start.heading)
        heading = wrapped(start.heading + reading.heading)
        self.turned += wrapped(heading - self.heading)
        self.x, self.y = start.x + c * reading.x - s * reading.y, start.y + s * reading.x + c * reading.y
        self.heading = heading

    def _move(self, left: float, right: float) -> None:
        """Advance along the arc given by the distances that the wheels rolled, in m."""
        travel = (left + right) / 2.0
        turn = (right - left) / self._track
        # The chord of the arc, 2 R sin(turn / 2), points along the heading at the middle of the arc.
        half = turn / 2.0
        chord = travel * (sin(half) / half if abs(half) > 1e-6 else 1.0 - half * half / 6.0)
        s, c = sincos(self.heading + half)
        self.x += chord * c
        self.y += chord * s
        self.heading = wrapped(self.heading + turn)
        self.turned += turn
