"""What a learner observes: ranges, the way to its goal, and its speeds, all from its own `Measures`.

Training and a mind on the network use the same class, so that a policy sees the same numbers in both.
"""

from __future__ import annotations

import math
from typing import Any, Final, Literal, TypeAlias

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from intellwheels_agents.differential_drive import Odometry, wrapped
from intellwheels_agents.range_scan import distance
from intellwheels_schemas.messages import Lidar, Measures, Position, Robot, Sensors

ObservationKind: TypeAlias = Literal["flat", "dict"]
KINDS: Final = ("flat", "dict")
Observation: TypeAlias = Any
"""A float32 array, or a dictionary of them: `observation_space` says which."""

FARTHEST: Final = 1000.0
"""Largest distance to a goal that is told apart, m."""
FASTEST: Final = 50.0
"""Largest speed, m/s, and turn rate, rad/s, that is told apart; 50 m/s is the contract's limit of a wheel."""


def observation_space(robot: Robot, kind: ObservationKind) -> spaces.Space[Any]:
    """Return the space of a robot's observations: float32, in m, rad, m/s and rad/s.

    `flat` is the ranges, then distance and bearing of the goal, then speed and turn rate. `dict` has them as `ranges`,
    `goal` and `speeds`. The ranges are those of the proximity sensors and then of the lidars' rays, in the order of
    the robot document, each in [0, MaxRange]. The bearing is in [-pi, pi], positive to the left.

    Raises:
        ValueError: There is no such kind, or the robot cannot tell where it is.
    """
    if kind not in KINDS:
        raise ValueError(f"observation: expected flat or dict, got {kind!r}")
    if not robot.odometry and not robot.encoders:
        raise ValueError("robot: expected encoders or odometry, which tell the way to the goal, got neither")
    high = np.array(_limits(robot), dtype=np.float32)
    goal = np.array([FARTHEST, np.pi], dtype=np.float32)
    speeds = np.array([FASTEST, FASTEST], dtype=np.float32)
    lows = {"ranges": np.zeros_like(high), "goal": np.array([0.0, -np.pi], dtype=np.float32), "speeds": -speeds}
    highs = {"ranges": high, "goal": goal, "speeds": speeds}
    if kind == "flat":
        return spaces.Box(np.concatenate(list(lows.values())), np.concatenate(list(highs.values())), dtype=np.float32)
    return spaces.Dict({name: spaces.Box(lows[name], highs[name], dtype=np.float32) for name in lows})


class Observer:
    """Turns the measures of one body into observations. It must see the measures of every tick, from the first on."""

    def __init__(
        self,
        robot: Robot,
        position: Position,
        goal: tuple[float, float],
        period: float,
        kind: ObservationKind = "flat",
    ) -> None:
        """Start an episode.

        Args:
            robot: The body as the simulator accepted it.
            position: Its pose when it joined.
            goal: x and y of the goal, m.
            period: Simulated time of a tick, s.
            kind: The kind of observation.
        """
        self._space = observation_space(robot, kind)
        self._kind = kind
        self._goal = goal
        self._period = period
        self._pose = Odometry(robot, position)
        self._speeds = (0.0, 0.0)
        self._limits = _limits(robot)
        self._ranges = list(self._limits)
        self._proximity = {sensor.id: (i, sensor) for i, sensor in enumerate(robot.proximity)}
        self._lidar: dict[str, tuple[int, Lidar]] = {}
        at = len(robot.proximity)
        for sensor in robot.lidar:
            self._lidar[sensor.id] = at, sensor
            at += sensor.rays

    def update(self, measures: Measures) -> None:
        """Take the measures of a tick. A sensor that did not measure keeps its last range."""
        before = self._pose.x, self._pose.y, self._pose.heading, self._pose.turned
        self._pose.update(measures.sensors)
        pose = self._pose
        middle = wrapped(before[2] + wrapped(pose.heading - before[2]) / 2.0)
        moved = (pose.x - before[0]) * math.cos(middle) + (pose.y - before[1]) * math.sin(middle)
        self._speeds = moved / self._period, (pose.turned - before[3]) / self._period
        if measures.sensors is not None:
            self._see(measures.sensors)

    def _see(self, sensors: Sensors) -> None:
        for reading in sensors.proximity:
            entry = self._proximity.get(reading.id)
            metres = None if entry is None else distance(reading, entry[1])
            if entry is not None and metres is not None:
                self._ranges[entry[0]] = min(max(metres, 0.0), entry[1].max_range)
        for scan in sensors.lidar:
            known = self._lidar.get(scan.id)
            if known is None:
                continue
            at, lidar = known
            for k, (value, status) in enumerate(zip(scan.ranges, scan.statuses, strict=False)):
                if k >= lidar.rays or status == "fault":
                    continue
                found = lidar.min_range if status == "near" else lidar.max_range if value is None else value
                self._ranges[at + k] = min(max(found, 0.0), lidar.max_range)

    def observation(self) -> Observation:
        """Return the observation after the last update, as `observation_space` describes it."""
        dx, dy = self._goal[0] - self._pose.x, self._goal[1] - self._pose.y
        bearing = wrapped(math.atan2(dy, dx) - self._pose.heading)
        goal = (min(math.hypot(dx, dy), FARTHEST), bearing)
        speeds = tuple(min(max(speed, -FASTEST), FASTEST) for speed in self._speeds)
        if self._kind == "flat":
            return self._inside(np.array([*self._ranges, *goal, *speeds], dtype=np.float32), self._space)
        parts = {"ranges": self._ranges, "goal": goal, "speeds": speeds}
        assert isinstance(self._space, spaces.Dict)  # noqa: S101 - its kind is dict
        return {name: self._inside(np.array(part, dtype=np.float32), self._space[name]) for name, part in parts.items()}

    @staticmethod
    def _inside(found: NDArray[np.float32], space: spaces.Space[Any]) -> NDArray[np.float32]:
        """Return an array whose rounding to float32 does not leave the space."""
        assert isinstance(space, spaces.Box)  # noqa: S101 - made above
        return np.clip(found, space.low, space.high)


def _limits(robot: Robot) -> list[float]:
    """Return the largest value of each range, m."""
    rays = [lidar.max_range for lidar in robot.lidar for _ in range(lidar.rays)]
    return [sensor.max_range for sensor in robot.proximity] + rays
