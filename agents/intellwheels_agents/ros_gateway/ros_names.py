"""Names of ROS for agents and sensors. Pure.

A name of ROS has letters, digits and single underscores. Each `-` and `.` of a name of the contract becomes `_`. Two
names that then are equal are refused, because their topics and frames would be one.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from intellwheels_schemas.errors import wrong_value
from intellwheels_schemas.messages import IMU, Lidar, Proximity, Robot

_OTHER: Final = re.compile(r"[^A-Za-z0-9]+")

BASE: Final = "base_link"
"""The body frame: centre of movement on the floor, x forward, y to the left, z up (REP 103, REP 105)."""
WHEELS: Final = ("left_wheel", "right_wheel")
"""Joints of the driven wheels."""
_RESERVED: Final = (BASE, "odom", "map", *WHEELS, *(f"{wheel}_link" for wheel in WHEELS))


def ros_name(text: str) -> str:
    """Return a name of ROS for a name of the contract, which begins with a letter."""
    return _OTHER.sub("_", text).strip("_")


def sensor_names(robot: Robot) -> Mapping[str, str]:
    """Return the names of ROS of the sensors that have a frame or a topic, by id.

    Raises:
        WireError: Two sensors would have the same name, or one that the gateway uses itself.
    """
    kinds: tuple[Sequence[Proximity | Lidar | IMU], ...] = (robot.proximity, robot.lidar, robot.imu)
    return _distinct(sensor.id for kind in kinds for sensor in kind)


def _distinct(ids: Iterable[str]) -> Mapping[str, str]:
    names: dict[str, str] = {}
    owners = dict.fromkeys(_RESERVED, "the gateway's own frame")
    for sensor in ids:
        name = ros_name(sensor)
        if name in owners:
            expected = f"an id whose name in ROS is not {name!r}, as that of {owners[name]}"
            raise wrong_value(f"sensor {sensor!r}", expected, repr(sensor))
        owners[name] = f"sensor {sensor!r}"
        names[sensor] = name
    return names
