"""Poses on the floor, and the quaternions that ROS writes them with. Pure.

Source:
    REP 103: x forward, y to the left, z up; a heading is a rotation about z.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

from intellwheels_agents.differential_drive import wrapped
from intellwheels_schemas.errors import wrong_value

FLAT: Final = 1e-3
"""Largest height (m), and largest part of a quaternion about x or y, of a pose that is on the floor."""
UNIT: Final = 0.01
"""Largest difference of a quaternion's norm from 1."""
FARTHEST: Final = 10_000.0
"""Largest coordinate of the contract, m."""


@dataclass(frozen=True, slots=True)
class PlanePose:
    """A pose, or the transform from its frame to the parent's.

    Attributes:
        x, y: Metres, in the parent frame.
        heading: Radians, in (-pi, pi], anticlockwise.
    """

    x: float
    y: float
    heading: float

    def __matmul__(self, other: PlanePose) -> PlanePose:
        """Return the pose in the parent frame of a pose in this frame."""
        sine, cosine = math.sin(self.heading), math.cos(self.heading)
        return PlanePose(
            self.x + cosine * other.x - sine * other.y,
            self.y + sine * other.x + cosine * other.y,
            wrapped(self.heading + other.heading),
        )

    def inverse(self) -> PlanePose:
        """Return the pose of the parent frame in this frame."""
        sine, cosine = math.sin(self.heading), math.cos(self.heading)
        return PlanePose(-cosine * self.x - sine * self.y, sine * self.x - cosine * self.y, wrapped(-self.heading))


def half_angle(heading: float) -> tuple[float, float]:
    """Return z and w of the quaternion of a heading; its x and y are 0."""
    return math.sin(heading / 2.0), math.cos(heading / 2.0)


def pose_on_floor(pose: Any, where: str) -> PlanePose:
    """Return the pose of a `geometry_msgs/Pose`.

    Args:
        pose: The message.
        where: What it is, for the error.

    Raises:
        WireError: A number is not finite, the quaternion has not the norm 1, or the pose is not on the floor.
    """
    position, turn = pose.position, pose.orientation
    numbers = (position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w)
    if not all(map(math.isfinite, numbers)):
        raise wrong_value(where, "finite numbers", "nan or inf")
    if max(abs(position.x), abs(position.y)) > FARTHEST:
        raise wrong_value(f"{where}.position", f"metres up to {FARTHEST:g}", f"{position.x:g}, {position.y:g}")
    norm = math.sqrt(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z + turn.w * turn.w)
    if abs(norm - 1.0) > UNIT:
        raise wrong_value(f"{where}.orientation", "a quaternion of norm 1", f"norm {norm:.3g}")
    if max(abs(position.z), abs(turn.x), abs(turn.y)) > FLAT:
        raise wrong_value(where, "a pose on the floor: z 0, turned about z only", f"z {position.z:g}")
    return PlanePose(position.x, position.y, wrapped(2.0 * math.atan2(turn.z, turn.w)))
