"""The odometry of a chair: pose since the start of the run, velocity and covariances. Pure.

The pose is that of the chair's odometry sensor, or follows from its encoders. Either way the wheels' travel since the
last sample gives the covariance, by the filter of the bridge (`bridge/pose_estimate.py`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from intellwheels_agents.bridge.pose_estimate import ZERO, Covariance, PoseEstimate, wheel_geometry
from intellwheels_agents.bridge.pose_source import DRIFT
from intellwheels_agents.differential_drive import wrapped
from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_schemas.messages import Position, Robot, Sensors

LEAST_VARIANCE: Final = 1e-9
"""Smallest variance that is published: a filter cannot use 0."""


@dataclass(frozen=True, slots=True)
class OdometrySample:
    """The odometry at a tick.

    Attributes:
        tick: The tick of the sample.
        pose: Pose in the frame `odom`, m and rad.
        covariance: Of that pose: xx xy xh yy yh hh.
        speed: Forward, m/s, mean since the last sample.
        turn_rate: Anticlockwise, rad/s, mean since the last sample.
        speed_variance: m2/s2.
        turn_variance: rad2/s2.
    """

    tick: int
    pose: PlanePose
    covariance: Covariance = ZERO
    speed: float = 0.0
    turn_rate: float = 0.0
    speed_variance: float = 0.0
    turn_variance: float = 0.0


class WheelOdometry:
    """Turns the readings of one run into odometry."""

    def __init__(self, robot: Robot, period: float) -> None:
        """Take a robot and the seconds of a tick."""
        self._wheels = wheel_geometry(robot)
        self._period = period
        self._drift = max([encoders.drift for encoders in robot.encoders[:1]] + [DRIFT])
        self._estimate = PoseEstimate(Position(x=0.0, y=0.0, heading=0.0), self._drift)
        self._counts: tuple[int, int] | None = None
        self._tick = -1

    def update(self, sensors: Sensors | None, tick: int) -> OdometrySample | None:
        """Return the odometry of the readings of a tick; None if they have none that is new."""
        if sensors is not None and sensors.odometry:
            reading = sensors.odometry[0]
            pose = PlanePose(reading.x, reading.y, reading.heading)
            return self._moved(self._travel_to(pose), reading.tick, tick, pose)
        if sensors is not None and sensors.encoders:
            counts = sensors.encoders[0]
            last = self._counts or (counts.left, counts.right)
            self._counts = counts.left, counts.right
            travel = (counts.left - last[0]) * self._wheels.left, (counts.right - last[1]) * self._wheels.right
            return self._moved(travel, counts.tick, tick, None)
        return None

    def _travel_to(self, pose: PlanePose) -> tuple[float, float]:
        """Return the travel of both wheels on the arc to a pose, m."""
        here = self._estimate
        if self._tick < 0:
            return 0.0, 0.0
        dx, dy, turn = pose.x - here.x, pose.y - here.y, wrapped(pose.heading - here.heading)
        middle = here.heading + turn / 2.0
        half = turn / 2.0
        travel = (dx * math.cos(middle) + dy * math.sin(middle)) * (half / math.sin(half) if abs(half) > 1e-6 else 1.0)
        return travel - turn * self._wheels.track / 2.0, travel + turn * self._wheels.track / 2.0

    def _moved(
        self, travel: tuple[float, float], sampled: int | None, tick: int, pose: PlanePose | None
    ) -> OdometrySample | None:
        at = tick if sampled is None else sampled
        if at <= self._tick:
            return None
        seconds = (at - self._tick) * self._period if self._tick >= 0 else math.inf
        self._tick = at
        left, right = travel
        estimate, track = self._estimate, self._wheels.track
        estimate.predict(left, right, track)
        if pose is not None:
            estimate.x, estimate.y, estimate.heading = pose.x, pose.y, pose.heading
        rolled = self._drift * (abs(left) + abs(right)) / (seconds * seconds)
        return OdometrySample(
            at,
            PlanePose(estimate.x, estimate.y, estimate.heading),
            estimate.covariance,
            (left + right) / 2.0 / seconds,
            (right - left) / track / seconds,
            rolled / 4.0 + LEAST_VARIANCE,
            rolled / (track * track) + LEAST_VARIANCE,
        )
