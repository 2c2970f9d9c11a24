"""The frames of a chair (REP 105): `map`, `<name>/odom`, `<name>/base_link`, and one for each sensor. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.ros_names import BASE, sensor_names
from intellwheels_schemas.messages import Lidar, Proximity, Robot

MAP: Final = "map"
"""The map frame, which is that of the contract."""


class SensorFrame(NamedTuple):
    """A frame that is fixed to the body.

    Attributes:
        name: Its name, without that of the chair.
        pose: The sensor's pose in the body frame; x is its axis.
        height: Metres above the floor.
        fixed_at_start: Whether the sensor stays where the chair started, as one on a door frame does.
    """

    name: str
    pose: PlanePose
    height: float
    fixed_at_start: bool = False


def sensor_frames(robot: Robot) -> Mapping[str, SensorFrame]:
    """Return the frames of the proximity sensors, lidars and IMUs of a robot, by id.

    Raises:
        WireError: Two sensors would have the same name.
    """
    names = sensor_names(robot)
    mounted: tuple[Proximity | Lidar, ...] = (*robot.proximity, *robot.lidar)
    frames = {
        sensor.id: SensorFrame(
            names[sensor.id],
            PlanePose(sensor.x, sensor.y, math.radians(sensor.direction_deg)),
            sensor.z,
            sensor.mount == "start",
        )
        for sensor in mounted
    }
    # An IMU measures at the centre of movement; the contract gives it no height.
    return frames | {imu.id: SensorFrame(names[imu.id], PlanePose(0.0, 0.0, 0.0), 0.0) for imu in robot.imu}


def frame_of(chair: str, name: str) -> str:
    """Return the full name of a frame of a chair."""
    return f"{chair}/{name}"


def is_base(frame: str, chair: str) -> bool:
    """Return whether the frame of a velocity is that of the body: none, `base_link`, or the chair's own."""
    return frame.removeprefix("/") in ("", BASE, frame_of(chair, BASE))
