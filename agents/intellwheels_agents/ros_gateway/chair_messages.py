"""What a chair publishes at a tick: its topics, their qualities of service, and the messages. Pure.

    /<name>/odom          nav_msgs/Odometry            odometry sensor, or encoders
    /tf                   tf2_msgs/TFMessage           map to odom to base_link
    /tf_static            tf2_msgs/TFMessage           base_link to each sensor; once a run
    /<name>/scan          sensor_msgs/LaserScan        the first lidar; others at /<name>/scan/<id>
    /<name>/range/<id>    sensor_msgs/Range            each proximity sensor
    /<name>/imu           sensor_msgs/Imu              the first IMU; others at /<name>/imu/<id>
    /<name>/joint_states  sensor_msgs/JointState       encoders
    /diagnostics          diagnostic_msgs/DiagnosticArray   once a second, and when something changes

The stamp of a message is the simulated time of its sample.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any, Final, Literal, NamedTuple

from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.rmw_wire import LATCHED, SENSOR_DATA, Qos
from intellwheels_agents.ros_gateway.robot_frames import MAP, frame_of, sensor_frames
from intellwheels_agents.ros_gateway.ros_messages import (
    header,
    matrix,
    pose_message,
    transform,
    transforms,
    twist_message,
)
from intellwheels_agents.ros_gateway.ros_names import BASE
from intellwheels_agents.ros_gateway.ros_types import made_of
from intellwheels_agents.ros_gateway.sensor_messages import (
    UNMEASURED,
    JointStates,
    imu_message,
    laser_scan,
    range_message,
)
from intellwheels_agents.ros_gateway.wheel_odometry import LEAST_VARIANCE, OdometrySample, WheelOdometry
from intellwheels_schemas.messages import Measures, Robot, Sensors

Localisation = Literal["start", "truth", "none"]
"""Where `map` to `odom` comes from: the start pose, the truth sensor, or another node."""
DIAGNOSTICS_PERIOD: Final = 1.0
"""Simulated seconds between two messages of diagnostics while nothing changes."""
SHORTEST_TICK: Final = 0.0009
"""Seconds; 0.001 in the contract (Period), and a margin as times are rounded."""
LONGEST_TICK: Final = 1.001
"""Seconds; 1 in the contract (Period), and a margin."""
_SCAN, _IMU = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/Imu"
_OK, _WARN = 0, 1


class Topic(NamedTuple):
    """A topic that is published."""

    name: str
    type: str
    qos: Qos = Qos()


class Outgoing(NamedTuple):
    """A message for a topic."""

    topic: str
    message: Any


TF: Final = Topic("/tf", "tf2_msgs/msg/TFMessage", Qos(depth=100))
TF_STATIC: Final = Topic("/tf_static", "tf2_msgs/msg/TFMessage", LATCHED)
DIAGNOSTICS: Final = Topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")


def has_odometry(robot: Robot) -> bool:
    """Return whether a robot has a sensor that odometry follows from."""
    return bool(robot.odometry or robot.encoders)


def chair_topics(chair: str, robot: Robot) -> Sequence[Topic]:
    """Return the topics that a robot has sensors for.

    Args:
        chair: Name of the chair in ROS.
        robot: Its robot.

    Raises:
        WireError: Two sensors would have the same name.
    """
    frames = sensor_frames(robot)
    found = [TF_STATIC, DIAGNOSTICS]
    if has_odometry(robot):
        found += [TF, Topic(f"/{chair}/odom", "nav_msgs/msg/Odometry")]
    if robot.encoders:
        found.append(Topic(f"/{chair}/joint_states", "sensor_msgs/msg/JointState"))
    for kind, sensors, of in (("scan", robot.lidar, _SCAN), ("imu", robot.imu, _IMU)):
        names = [frames[sensor.id].name for sensor in sensors]
        found += [Topic(f"/{chair}/{kind}{f'/{name}' if index else ''}", of, SENSOR_DATA)
                  for index, name in enumerate(names)]  # fmt: skip
    found += [
        Topic(f"/{chair}/range/{frames[sensor.id].name}", "sensor_msgs/msg/Range", SENSOR_DATA)
        for sensor in robot.proximity
    ]
    return found


def tick_length(measures: Measures) -> float | None:
    """Return the seconds of a tick, or None for measures that no simulator sends: a stranger's.

    Their time is not what the contract allows for their tick, or a sample is of a later tick.
    """
    sensors, tick = measures.sensors or Sensors(), measures.tick
    samples: Iterator[Any] = chain(
        sensors.odometry, sensors.encoders, sensors.lidar, sensors.proximity, sensors.imu, sensors.truth
    )
    if tick < 1 or any(sample.tick is not None and sample.tick > tick for sample in samples):
        return None
    seconds = measures.time / tick
    return seconds if SHORTEST_TICK <= seconds <= LONGEST_TICK else None


class ChairMessages:
    """Turns the measures of one run into messages."""

    def __init__(
        self, chair: str, robot: Robot, period: float, start: PlanePose, localisation: Localisation = "start", *,
        moved: bool = False,
    ) -> None:  # fmt: skip
        """Begin a run.

        Args:
            chair: Name of the chair in ROS.
            robot: The robot, as the simulator accepted it.
            period: Seconds of a tick.
            start: Pose of the body at the start of the run, in the map frame.
            localisation: Where the pose of `odom` on the map comes from.
            moved: Whether `start` is the pose at the first measures, and the odometry may have begun before.
        """
        self._chair = chair
        self._robot = robot
        self._period = period
        self._map_to_odom = start
        self._moved = moved
        self._localisation = localisation
        self._frames = sensor_frames(robot)
        self._odometry = WheelOdometry(robot, period)
        self._joints = JointStates(robot, period)
        self._told: tuple[float, object] = (-math.inf, None)
        self._base, self._odom = frame_of(chair, BASE), frame_of(chair, "odom")
        self._scans = self._topics_by_id("scan", [lidar.id for lidar in robot.lidar])
        self._imus = self._topics_by_id("imu", [imu.id for imu in robot.imu])
        self._lidars = {lidar.id: lidar for lidar in robot.lidar}
        self._units = {imu.id: imu for imu in robot.imu}
        self._wedges = {sensor.id: sensor for sensor in robot.proximity}

    def _topics_by_id(self, kind: str, ids: Sequence[str]) -> dict[str, str]:
        return {
            one: f"/{self._chair}/{kind}{f'/{self._frames[one].name}' if index else ''}"
            for index, one in enumerate(ids)
        }

    def takes(self, measures: Measures) -> bool:
        """Return whether measures can be of this run, in which all ticks are as long."""
        seconds = tick_length(measures)
        # Times have six digits after the point, so those of short ticks are not exact.
        return seconds is not None and math.isclose(seconds, self._period, rel_tol=0.01)

    def static(self) -> Outgoing:
        """Return the transforms that do not change in a run."""
        items = [
            transform(self._odom if frame.fixed_at_start else self._base, frame_of(self._chair, frame.name),
                      frame.pose, 0.0, frame.height)
            for frame in self._frames.values()
        ]  # fmt: skip
        return Outgoing(TF_STATIC.name, transforms(items))

    def messages(self, measures: Measures) -> Iterator[Outgoing]:
        """Yield the messages for the measures of a tick."""
        sensors, tick = measures.sensors, measures.tick
        sample = self._odometry.update(sensors, tick)
        if sample is not None:
            yield from self._odometry_messages(sample, measures)
        if sensors is not None:
            for encoders in sensors.encoders[:1]:
                at = tick if encoders.tick is None else encoders.tick
                yield Outgoing(f"/{self._chair}/joint_states", self._joints.message(self._time(at), at, encoders))
            for scan in sensors.lidar:
                if scan.id in self._lidars:
                    seconds = self._time(tick if scan.tick is None else scan.tick) if scan.stamp is None else scan.stamp
                    message = laser_scan(self._frame(scan.id), seconds, self._lidars[scan.id], scan, self._period)
                    yield Outgoing(self._scans[scan.id], message)
            for near in sensors.proximity:
                if near.id in self._wedges:
                    seconds = self._time(tick if near.tick is None else near.tick)
                    message = range_message(self._frame(near.id), seconds, self._wedges[near.id], near)
                    yield Outgoing(f"/{self._chair}/range/{self._frames[near.id].name}", message)
            for imu in sensors.imu:
                if imu.id in self._units:
                    seconds = self._time(tick if imu.tick is None else imu.tick)
                    yield Outgoing(
                        self._imus[imu.id], imu_message(self._frame(imu.id), seconds, self._units[imu.id], imu)
                    )
        yield from self._diagnostics(measures)

    def _time(self, tick: int) -> float:
        return tick * self._period

    def _frame(self, sensor: str) -> str:
        return frame_of(self._chair, self._frames[sensor].name)

    def _odometry_messages(self, sample: OdometrySample, measures: Measures) -> Iterator[Outgoing]:
        seconds = self._time(sample.tick)
        xx, xy, xh, yy, yh, hh = sample.covariance
        # Rows of ROS: x, y, z, roll, pitch, yaw. The floor holds z, roll and pitch.
        pose_entries = {
            (0, 0): xx + LEAST_VARIANCE, (0, 1): xy, (0, 5): xh, (1, 1): yy + LEAST_VARIANCE, (1, 5): yh,
            (5, 5): hh + LEAST_VARIANCE,
        }  # fmt: skip
        twist_entries = {(0, 0): sample.speed_variance, (5, 5): sample.turn_variance}
        yield Outgoing(
            f"/{self._chair}/odom",
            made_of("nav_msgs/msg/Odometry")(
                header=header(self._odom, seconds),
                child_frame_id=self._base,
                pose=made_of("geometry_msgs/msg/PoseWithCovariance")(
                    pose=pose_message(sample.pose), covariance=matrix(6, pose_entries, UNMEASURED)
                ),
                twist=made_of("geometry_msgs/msg/TwistWithCovariance")(
                    twist=twist_message(sample.speed, sample.turn_rate), covariance=matrix(6, twist_entries, UNMEASURED)
                ),
            ),
        )
        items = [transform(self._odom, self._base, sample.pose, seconds)]
        if self._localisation != "none":
            self._localise(sample, measures)
            items.insert(0, transform(MAP, self._odom, self._map_to_odom, seconds))
        yield Outgoing(TF.name, transforms(items))

    def _localise(self, sample: OdometrySample, measures: Measures) -> None:
        """Take over the true pose, if it is known for the tick of the odometry."""
        if self._moved:
            self._moved = False
            self._map_to_odom = self._map_to_odom @ sample.pose.inverse()
        truths = measures.sensors.truth if self._localisation == "truth" and measures.sensors is not None else ()
        for truth in truths[:1]:
            if (measures.tick if truth.tick is None else truth.tick) == sample.tick:
                self._map_to_odom = PlanePose(truth.x, truth.y, truth.heading) @ sample.pose.inverse()

    def _diagnostics(self, measures: Measures) -> Iterator[Outgoing]:
        facts = measures.state, measures.collision, measures.contact
        told_at, told = self._told
        if facts == told and measures.time < told_at + DIAGNOSTICS_PERIOD:
            return
        self._told = measures.time, facts
        fine = measures.state == "drive" and not measures.collision
        values = {"state": measures.state, "collision": measures.collision, "contact": measures.contact}
        pair = made_of("diagnostic_msgs/msg/KeyValue")
        status = made_of("diagnostic_msgs/msg/DiagnosticStatus")(
            level=_OK if fine else _WARN,
            name=f"{self._chair}: motors",
            message="blocked" if measures.state == "drive" and measures.collision else measures.state,
            hardware_id=self._chair,
            values=[pair(key=key, value=str(value).lower()) for key, value in values.items()],
        )
        array = made_of("diagnostic_msgs/msg/DiagnosticArray")(header=header("", measures.time), status=[status])
        yield Outgoing(DIAGNOSTICS.name, array)
