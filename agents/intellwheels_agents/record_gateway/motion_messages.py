"""Poses, transforms, scans and log lines as messages of Foxglove. Pure; times are nanoseconds, positions metres.

The frame of an agent has its name: origin at the centre of movement, x forward, y to the left, z 0 on the floor.
`<agent>/start` is that frame at the moment of joining, in which odometry counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

from foxglove.messages import (
    FrameTransform,
    FrameTransforms,
    LaserScan,
    Log,
    LogLevel,
    Odometry,
    Pose,
    PoseInFrame,
    Quaternion,
    Timestamp,
    Vector3,
)

from intellwheels_schemas.messages import Entity, Error, Event, Goal, LidarReading, OdometryReading, Robot

MAP: Final = "map"
"""The frame of the map."""
_BILLION: Final = 1_000_000_000
_NO_RANGE: Final = {"none": math.inf, "near": -math.inf}
"""Ranges without a value, as REP 117 of ROS has them; NaN for a fault."""


def frame_of(agent: str) -> str:
    """Return the frame of a body. An agent may be called `map`."""
    return f"{agent}/body"


def start_frame_of(agent: str) -> str:
    """Return the frame in which a body joined."""
    return f"{agent}/start"


def stamp_of(time: int) -> Timestamp:
    """Return a time, ns, as a message."""
    return Timestamp(time // _BILLION, time % _BILLION)


def transforms(entities: Iterable[Entity], robots: dict[str, Robot], time: int) -> FrameTransforms:
    """Return where the frames of all bodies are in the map."""
    found = []
    for entity in entities:
        found.append(_transform(frame_of(entity.name), entity.x, entity.y, entity.heading, time))
        robot = robots.get(entity.name)
        if robot is not None and robot.position is not None:
            start = robot.position
            found.append(_transform(start_frame_of(entity.name), start.x, start.y, start.heading, time))
    return FrameTransforms(transforms=found)


def pose_in_map(x: float, y: float, heading: float, time: int) -> PoseInFrame:
    """Return a pose in the map frame."""
    return PoseInFrame(timestamp=stamp_of(time), frame_id=MAP, pose=plane_pose(x, y, heading))


def goal_in_map(goal: Goal, time: int) -> PoseInFrame:
    """Return a goal; one without heading has heading 0."""
    return pose_in_map(goal.x, goal.y, goal.heading or 0.0, time)


def true_motion(entity: Entity, time: int) -> Odometry:
    """Return the true pose and twist of a body; the twist is in its own frame."""
    return Odometry(
        timestamp=stamp_of(time),
        frame_id=MAP,
        body_frame_id=frame_of(entity.name),
        pose=plane_pose(entity.x, entity.y, entity.heading),
        linear_velocity=Vector3(x=entity.speed, y=0.0, z=0.0),
        angular_velocity=Vector3(x=0.0, y=0.0, z=entity.turn_rate),
    )


def odometry(agent: str, reading: OdometryReading, time: int) -> Odometry:
    """Return a pose by dead reckoning. The sensor has no twist, so there is none."""
    return Odometry(
        timestamp=stamp_of(time),
        frame_id=start_frame_of(agent),
        body_frame_id=frame_of(agent),
        pose=plane_pose(reading.x, reading.y, reading.heading),
    )


def laser_scan(agent: str, robot: Robot, reading: LidarReading, time: int) -> LaserScan | None:
    """Return a scan, or None of a sensor that the robot does not have."""
    sensor = next((one for one in robot.lidar if one.id == reading.id), None)
    if sensor is None:
        return None
    start, step = math.radians(reading.start_deg), math.radians(reading.step_deg)
    statuses = reading.statuses or ("ok",) * len(reading.ranges)
    return LaserScan(
        timestamp=stamp_of(time),
        frame_id=frame_of(agent) if sensor.mount == "body" else start_frame_of(agent),
        pose=Pose(position=Vector3(x=sensor.x, y=sensor.y, z=sensor.z), orientation=Quaternion(x=0, y=0, z=0, w=1)),
        start_angle=start,
        end_angle=start + step * max(len(reading.ranges) - 1, 0),
        ranges=[
            _NO_RANGE.get(status, math.nan) if value is None else value
            for value, status in zip(reading.ranges, statuses, strict=False)
        ],
    )


def log_of_event(event: Event, time: int) -> Log:
    """Return an event as a line of a log; a contact is a warning."""
    words: list[str] = [event.code]
    pairs = (
        ("agent", event.agent), ("other", event.other), ("x", event.x), ("y", event.y), ("speed", event.speed),
        ("text", event.text),
    )  # fmt: skip
    words += [f"{name}={value:g}" if isinstance(value, float) else f"{name}={value}" for name, value in pairs if value]
    level = LogLevel.Warning if event.code in ("contact", "late", "lost", "timeout", "stale") else LogLevel.Info
    return log_line(" ".join(words), event.agent or "world", level, time)


def log_of_error(agent: str, error: Error, time: int) -> Log:
    """Return an error in a message of an agent as a line of a log."""
    return log_line(f"{error.code}: {error.text}", agent, LogLevel.Error, time)


def log_line(text: str, name: str, level: LogLevel, time: int) -> Log:
    """Return a line of a log."""
    return Log(timestamp=stamp_of(time), level=level, message=text, name=name)


def plane_pose(x: float, y: float, heading: float) -> Pose:
    """Return a pose on the floor."""
    return Pose(position=Vector3(x=x, y=y, z=0.0), orientation=_turn(heading))


def _transform(frame: str, x: float, y: float, heading: float, time: int) -> FrameTransform:
    return FrameTransform(
        timestamp=stamp_of(time),
        parent_frame_id=MAP,
        child_frame_id=frame,
        translation=Vector3(x=x, y=y, z=0.0),
        rotation=_turn(heading),
    )


def _turn(heading: float) -> Quaternion:
    return Quaternion(x=0.0, y=0.0, z=math.sin(heading / 2.0), w=math.cos(heading / 2.0))
