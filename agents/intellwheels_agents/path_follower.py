"""Keeping a chair to a path: how fast and how sharply, by pure pursuit, gently to who sits in it."""

from __future__ import annotations

import math
from typing import NamedTuple

from intellwheels_agents.differential_drive import Odometry, wrapped
from intellwheels_agents.pure_pursuit import Path

TURN_RATE = 0.8
"""Radians a second at most."""
TURN_IN_PLACE = math.radians(50.0)
"""When the target lies further to the side than this the chair turns before it drives."""
BRAKING = 0.35
"""Metres a second squared: gentle to who sits in the chair."""
CREEP = 0.05
"""Metres a second: the least that is worth moving."""


class Steering(NamedTuple):
    """What keeps to the path.

    Attributes:
        speed: Forward, m/s, at least `CREEP`; 0 while it turns in place.
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
    """Steers one chair.

    Args:
        speed: On the straight, m/s.
    """

    def __init__(self, speed: float) -> None:
        self._speed = speed
        self._turning = False

    def steer(self, path: Path, pose: Odometry, room: float) -> Steering:
        """Return what keeps to the path.

        Args:
            path: Updated with the pose.
            pose: Where the chair believes it is.
            room: Metres in which it must be able to stop.
        """
        reach = max(0.45, 0.9 * self._speed)
        target_x, target_y = path.ahead(reach)
        dx, dy = target_x - pose.x, target_y - pose.y
        bearing = wrapped(math.atan2(dy, dx) - pose.heading)
        # Two thresholds, or it would begin to drive and to turn by turns.
        self._turning = abs(bearing) > (TURN_IN_PLACE / 3.0 if self._turning else TURN_IN_PLACE)
        if self._turning:
            return Steering(0.0, 0.0, min(max(2.0 * bearing, -TURN_RATE), TURN_RATE))
        curvature = 2.0 * math.sin(bearing) / max(math.hypot(dx, dy), 1e-3)
        speed = min(self._speed, TURN_RATE / max(abs(curvature), 1e-6), braking(room))
        return Steering(max(speed, CREEP), curvature, 0.0)


def braking(distance: float) -> float:
    """Return the speed, m/s, from which `BRAKING` stops a chair within a distance, m."""
    return math.sqrt(2.0 * BRAKING * max(distance, 0.0))
