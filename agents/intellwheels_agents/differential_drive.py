"""A chair as its controller sees it: speeds to wheel powers, encoders and compass to a pose.

With v the forward speed (m/s), w the turn rate (rad/s, anticlockwise) and b the track (m):

    left = v - w b / 2,  right = v + w b / 2,  power = wheel speed / top speed

Nothing here knows the truth; a pose is what the chair believes.
"""

from __future__ import annotations

import math

from intellwheels_schemas.messages import OdometryReading, Position, Robot, Sensors


def wrapped(angle: float) -> float:
    """Return the angle in (-pi, pi]."""
    wrapped_angle = math.remainder(angle, 2.0 * math.pi)
    return math.pi if wrapped_angle == -math.pi else wrapped_angle


def powers(robot: Robot, speed: float, turn_rate: float) -> tuple[float, float]:
    """Return the left and right power, both in [-1, 1], that give these speeds.

    When a wheel cannot turn that fast both are slowed, so that the curvature is kept.

    Args:
        robot: Gives the track and the top speed.
        speed: Forward, in m/s.
        turn_rate: Anticlockwise, in rad/s.
    """
    if robot.top_speed <= 0.0:
        return 0.0, 0.0
    half = turn_rate * robot.track / 2.0
    left, right = (speed - half) / robot.top_speed, (speed + half) / robot.top_speed
    most = max(1.0, abs(left), abs(right))
    return left / most, right / most


class Odometry:
    """A pose kept by encoders, its heading corrected by a compass.

    Attributes:
        x, y: Metres, in the map's frame.
        heading: Radians, in (-pi, pi].
        turned: Radians turned since the start, not wrapped.
    """

    def __init__(self, robot: Robot, start: Position, compass_share: float = 0.05) -> None:
        """Start at a pose, with the wheel figures of `robot`.

        Args:
            robot: Gives track, wheel diameter and ticks of a turn.
            start: The pose before the first reading.
            compass_share: Share k of the compass' difference taken over each tick. The encoders' heading is right
                from tick to tick and drifts over minutes, the compass is wrong by its noise at every tick and never
                drifts: k leaves sqrt(k / (2 - k)) of the noise, 0.16 for 0.05, and forgets a drift within 1 / k ticks.
        """
        self.x = start.x
        self.y = start.y
        self.heading = wrapped(start.heading)
        self.turned = 0.0
        self._start = start
        self._compass_share = compass_share
        self._track = robot.track
        self._metres_per_tick = math.pi * robot.wheel_diameter / robot.encoder_ticks
        self._last: tuple[int, int] | None = None

    def update(self, sensors: Sensors | None) -> None:
        """Take the readings of a tick; those that are absent change nothing.

        A body with an odometry sensor is told its pose since it joined: of a real chair that is what its bridge
        reports, calibrated or corrected, which this chair's own counts are not.
        """
        if sensors is None:
            return
        if sensors.odometry:
            self._take_told(sensors.odometry[0])
            return
        if sensors.encoders:
            reading = sensors.encoders[0]
            # Counts began when the body joined, maybe long before this mind; the first is where we begin.
            last_left, last_right = self._last or (reading.left, reading.right)
            self._move(
                (reading.left - last_left) * self._metres_per_tick, (reading.right - last_right) * self._metres_per_tick
            )
            self._last = (reading.left, reading.right)
        if sensors.compass:
            value = sensors.compass[0].value
            if value is not None:
                self.heading = wrapped(self.heading + self._compass_share * wrapped(value - self.heading))

    def _take_told(self, told: OdometryReading) -> None:
        """Take a pose since joining."""
        start = self._start
        c, s = math.cos(start.heading), math.sin(start.heading)
        heading = wrapped(start.heading + told.heading)
        self.turned += wrapped(heading - self.heading)
        self.x, self.y = start.x + c * told.x - s * told.y, start.y + s * told.x + c * told.y
        self.heading = heading

    def _move(self, left: float, right: float) -> None:
        """Advance along the arc both wheels rolled, in metres."""
        travel = (left + right) / 2.0
        turn = (right - left) / self._track
        # The chord of the arc: 2 R sin(turn / 2), along the heading of its middle.
        half = turn / 2.0
        chord = travel * (math.sin(half) / half if abs(half) > 1e-6 else 1.0 - half * half / 6.0)
        self.x += chord * math.cos(self.heading + half)
        self.y += chord * math.sin(self.heading + half)
        self.heading = wrapped(self.heading + turn)
        self.turned += turn
