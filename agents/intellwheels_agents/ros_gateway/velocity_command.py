"""The velocity that a ROS node wants, as motor powers, with a dead-man. Pure.

A velocity counts for `DEAD_MAN` seconds of simulated time. Without a new one both powers are 0.
"""

from __future__ import annotations

import math
from typing import Any, Final

from intellwheels_agents.differential_drive import powers
from intellwheels_agents.ros_gateway.robot_frames import is_base
from intellwheels_schemas.errors import wrong_value
from intellwheels_schemas.messages import Robot

DEAD_MAN: Final = 0.5
"""Simulated seconds for which a velocity counts."""
TWIST: Final = "geometry_msgs/msg/Twist"
TWIST_STAMPED: Final = "geometry_msgs/msg/TwistStamped"
FASTEST: Final = 100.0
"""Largest speed of the contract, m/s."""
FASTEST_TURN: Final = 1000.0
"""Largest turn rate of the contract, rad/s."""
_ROUNDING: Final = 1e-6


class VelocityCommand:
    """The newest velocity.

    Attributes:
        stamp: Simulated time from which it counts, s; -inf without one.
    """

    def __init__(self, chair: str, robot: Robot) -> None:
        """Take the name of the chair in ROS, and its robot, which gives track and top speed."""
        self.stamp = -math.inf
        self._chair = chair
        self._robot = robot
        self._speed = 0.0
        self._turn_rate = 0.0

    def take(self, name: str, message: Any, now: float) -> None:
        """Take a velocity that has arrived.

        Args:
            name: The type of the message, `TWIST` or `TWIST_STAMPED`.
            message: The message. The stamp of a `TwistStamped` is simulated time; 0 means now.
            now: Simulated time, s.

        Raises:
            WireError: A number is not finite or too large, it asks for what a chair cannot do, or its frame or stamp is
                wrong.
        """
        stamp = now
        twist = message
        if name == TWIST_STAMPED:
            twist, header = message.twist, message.header
            if not is_base(header.frame_id, self._chair):
                raise wrong_value("cmd_vel.header.frame_id", f"{self._chair}/base_link", repr(header.frame_id[:80]))
            given = header.stamp.sec + header.stamp.nanosec * 1e-9
            if given:
                stamp = self._checked_stamp(given, now)
        speed, turn_rate = twist.linear.x, twist.angular.z
        others = (twist.linear.y, twist.linear.z, twist.angular.x, twist.angular.y)
        if not all(map(math.isfinite, (speed, turn_rate, *others))):
            raise wrong_value("cmd_vel", "finite numbers", "nan or inf")
        if abs(speed) > FASTEST or abs(turn_rate) > FASTEST_TURN:
            expected = f"at most {FASTEST:g} m/s and {FASTEST_TURN:g} rad/s"
            raise wrong_value("cmd_vel", expected, f"{speed:g} and {turn_rate:g}")
        if any(others):
            raise wrong_value("cmd_vel", "linear.x and angular.z only", f"other parts {others}")
        self._speed, self._turn_rate, self.stamp = speed, turn_rate, stamp

    def powers(self, now: float) -> tuple[float, float]:
        """Return the left and right motor powers, in [-1, 1], at a simulated time in s.

        If a wheel cannot turn so fast, both are scaled down, which keeps the curvature.
        """
        if now - self.stamp > DEAD_MAN + _ROUNDING:
            return 0.0, 0.0
        return powers(self._robot, self._speed, self._turn_rate)

    def _checked_stamp(self, given: float, now: float) -> float:
        if abs(now - given) > DEAD_MAN + _ROUNDING:
            expected = f"simulated time within {DEAD_MAN:g} s of {now:.3f} (use_sim_time)"
            raise wrong_value("cmd_vel.header.stamp", expected, f"{given:.3f}")
        return min(given, now)
