"""Messages of ROS from plain numbers: SI units, radians, simulated time. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from intellwheels_agents.ros_gateway.plane_pose import PlanePose, half_angle
from intellwheels_agents.ros_gateway.ros_types import made_of

NANO: Final = 1_000_000_000


def time_message(seconds: float) -> Any:
    """Return a `builtin_interfaces/Time`. Simulated time is a number of microseconds, so nothing is lost."""
    whole, rest = divmod(round(seconds * 1e6), 1_000_000)
    return made_of("builtin_interfaces/msg/Time")(sec=whole, nanosec=rest * 1000)


def header(frame: str, seconds: float) -> Any:
    """Return a `std_msgs/Header`."""
    return made_of("std_msgs/msg/Header")(stamp=time_message(seconds), frame_id=frame)


def vector(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    """Return a `geometry_msgs/Vector3`."""
    return made_of("geometry_msgs/msg/Vector3")(x=x, y=y, z=z)


def quaternion(heading: float) -> Any:
    """Return the `geometry_msgs/Quaternion` of a heading, rad."""
    z, w = half_angle(heading)
    return made_of("geometry_msgs/msg/Quaternion")(x=0.0, y=0.0, z=z, w=w)


def pose_message(pose: PlanePose) -> Any:
    """Return a `geometry_msgs/Pose` on the floor."""
    point = made_of("geometry_msgs/msg/Point")(x=pose.x, y=pose.y, z=0.0)
    return made_of("geometry_msgs/msg/Pose")(position=point, orientation=quaternion(pose.heading))


def twist_message(x: float, turn_rate: float, y: float = 0.0) -> Any:
    """Return a `geometry_msgs/Twist`, m/s and rad/s."""
    return made_of("geometry_msgs/msg/Twist")(linear=vector(x, y), angular=vector(z=turn_rate))


def accel_message() -> Any:
    """Return a `geometry_msgs/Accel` of zeros."""
    return made_of("geometry_msgs/msg/Accel")(linear=vector(), angular=vector())


def transform(parent: str, child: str, pose: PlanePose, seconds: float, height: float = 0.0) -> Any:
    """Return a `geometry_msgs/TransformStamped`: the pose of the child frame in the parent frame."""
    change = made_of("geometry_msgs/msg/Transform")(
        translation=vector(pose.x, pose.y, height), rotation=quaternion(pose.heading)
    )
    return made_of("geometry_msgs/msg/TransformStamped")(
        header=header(parent, seconds), child_frame_id=child, transform=change
    )


def transforms(items: Sequence[Any]) -> Any:
    """Return a `tf2_msgs/TFMessage`."""
    return made_of("tf2_msgs/msg/TFMessage")(transforms=list(items))


def matrix(size: int, entries: Mapping[tuple[int, int], float], least: float = 0.0) -> Any:
    """Return a symmetric covariance matrix, row by row.

    Args:
        size: Rows and columns.
        entries: Values by row and column, each above or on the diagonal.
        least: Value of the diagonal where `entries` has none.
    """
    found = np.zeros((size, size))
    np.fill_diagonal(found, least)
    for (row, column), value in entries.items():
        found[row, column] = found[column, row] = value
    return found.reshape(-1)


def floats(values: Iterable[float]) -> Any:
    """Return a `float32[]`."""
    return np.fromiter(values, dtype=np.float32)


def doubles(values: Iterable[float]) -> Any:
    """Return a `float64[]`."""
    return np.fromiter(values, dtype=np.float64)
