"""Follows a path by pure pursuit: speed and curvature, limited for the comfort of the person in the chair."""

from __future__ import annotations

import math
from typing import NamedTuple

from intellwheels_agents.differential_drive import Odometry, wrapped
from intellwheels_agents.portable_math import atan2, hypot, sin
from intellwheels_agents.pure_pursuit import Path

TURN_RATE = 0.8
"""Highest turn rate, rad/s: a quarter turn in two seconds."""
TURN_IN_PLACE = math.radians(50.0)
"""If the target lies further to the side than this, the chair turns in place before it drives."""
BRAKING = 0.35
"""Deceleration, m/s2: comfortable for the person in the chair."""
MIN_SPEED = 0.05
"""Lowest speed that is worth driving, m/s."""


class Steering(NamedTuple):
    """How to move to stay on the path.

    Attributes:
        speed: Forward, m/s, at least `MIN_SPEED`; 0 while it turns in place.
        curvature: Of the arc, 1/m, positive to the left.
        turn_rate: In place, rad/s; 0 while it drives.
    """

    speed: float
    curvature: float
    turn_rate: float

    @property
    def turns(self) -> bool:
        """Whether the chair turns in place."""
        return self.speed == 0.0


class PathFollower:
    """Steers one chair along paths.

    Args:
        speed: The speed on straight stretches, m/s.
    """

    def __init__(self, speed: float) -> None:
        self._speed = speed
        self._turning = False

    def steer(self, path: Path, pose: Odometry, stopping_distance: float) -> Steering:
        """Return how to move to stay on the path.

        Args:
            path: The path, updated with the pose.
            pose: The estimated pose of the chair.
            stopping_distance: Metres within which the chair must be able to stop.
        """
        look_ahead = max(0.45, 0.9 * self._speed)
        target_x, target_y = path.ahead(look_ahead)
        dx, dy = target_x - pose.x, target_y - pose.y
        bearing = wrapped(atan2(dy, dx) - pose.heading)
        # Two thresholds (hysteresis), so that it does not alternate between turning and driving.
        self._turning = abs(bearing) > (TURN_IN_PLACE / 3.0 if self._turning else TURN_IN_PLACE)
        if self._turning:
            return Steering(0.0, 0.0, min(max(2.0 * bearing, -TURN_RATE), TURN_RATE))
        curvature = 2.0 * sin(bearing) / max(hypot(dx, dy), 1e-3)
        speed = min(self._speed, TURN_RATE / max(abs(curvature), 1e-6), braking(stopping_distance))
        return Steering(max(speed, MIN_SPEED), curvature, 0.0)


def braking(distance: float) -> float:
    """Return the speed (m/s) from which `BRAKING` stops a chair within a distance (m)."""
    return math.sqrt(2.0 * BRAKING * max(distance, 0.0))
