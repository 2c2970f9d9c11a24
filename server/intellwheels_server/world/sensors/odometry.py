"""Odometry: the pose since joining, integrated tick by tick from the encoders' counts with the nominal dimensions.

It begins at (0, 0, 0), the pose at which the body joined. It reads the first simulated encoders of the robot and has
their errors, from the same noise. For a robot without encoders it uses perfect ones.

Source:
    Drift with a variance of k metres per metre for each wheel: sd(heading) = sqrt(2 k L) / b after L metres straight
    on, and sd(lateral) = sqrt(2 k L^3 / 3) / b, with b the track.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit

from intellwheels_schemas.messages import Encoders, Odometry, OdometryReading, Robot
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.geometry import arc
from intellwheels_server.world.kernels.measures_text import DECIMAL, HEADING
from intellwheels_server.world.kernels.sample_schedule import due_slot
from intellwheels_server.world.kernels.sensor_errors import memory_of
from intellwheels_server.world.sensors.angles import written_heading
from intellwheels_server.world.sensors.encoders import (
    COUNT_MEMORY,
    LEFT_COUNT,
    RIGHT_COUNT,
    count_rolled,
    encoder_figures,
)
from intellwheels_server.world.sensors.kind import Array, Fitted, Kind, ManyViews, View, Written

ODOMETRY_STREAM: Final = "@odometry"
"""The noise stream of odometry without encoders. No sensor can have this id."""

_WIDTH = 3
# Behind the memory of the encoders: the counts that the pose includes, and the pose.
_LEFT_USED, _RIGHT_USED, _X, _Y, _HEADING = (
    COUNT_MEMORY,
    COUNT_MEMORY + 1,
    COUNT_MEMORY + 2,
    COUNT_MEMORY + 3,
    COUNT_MEMORY + 4,
)
# Columns of the nominal dimensions, float64[sensors, 2]: metres per tick, track in metres.
_WAY, _TRACK = 0, 1


def read_encoders(robot: Robot) -> Encoders | None:
    """Return the encoders that a robot's odometry reads, None for perfect ones."""
    return next((one for one in robot.encoders if one.source == "simulated"), None)


@njit(cache=True, error_model="numpy")
def _take(tick: int, numbers: Floats, figures: Floats, nominal: Floats, schedule: Ints, samples: Floats) -> None:
    for sensor in range(schedule.shape[0]):
        place = memory_of(schedule, sensor, _WIDTH)
        count_rolled(tick, numbers, figures, schedule, sensor, place, samples)
        left = (samples[place + LEFT_COUNT] - samples[place + _LEFT_USED]) * nominal[sensor, _WAY]
        right = (samples[place + RIGHT_COUNT] - samples[place + _RIGHT_USED]) * nominal[sensor, _WAY]
        samples[place + _LEFT_USED] = samples[place + LEFT_COUNT]
        samples[place + _RIGHT_USED] = samples[place + RIGHT_COUNT]
        if left != 0.0 or right != 0.0:
            x, y, heading, _, _ = arc(
                samples[place + _X], samples[place + _Y], samples[place + _HEADING], 0.5 * (left + right),
                (right - left) / nominal[sensor, _TRACK],
            )  # fmt: skip
            samples[place + _X] = min(max(x, -rows.WORLD_EDGE), rows.WORLD_EDGE)
            samples[place + _Y] = min(max(y, -rows.WORLD_EDGE), rows.WORLD_EDGE)
            samples[place + _HEADING] = heading
        slot = due_slot(schedule, sensor, tick, _WIDTH)
        if slot >= 0:
            for at in range(_WIDTH):
                samples[slot + at] = samples[place + _X + at]


@njit(cache=True, error_model="numpy", nogil=True)
def _take_many(
    ticks: Ints, numbers: Floats, samples: Floats, first: int, end: int, figures: Floats, nominal: Floats,
    schedule: Ints,
) -> None:  # fmt: skip
    """Store the samples of some worlds, of which every array has a row each."""
    for world in range(first, end):
        _take(ticks[world], numbers[world], figures[world], nominal[world], schedule[world], samples[world])


@dataclass(frozen=True)
class OdometryBlock:
    """All odometry."""

    figures: Floats
    nominal: Floats
    schedule: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.numbers, self.figures, self.nominal, self.schedule, samples)

    def stackable(self) -> tuple[Array, ...]:
        """Return the arrays that `take_many` needs."""
        return self.figures, self.nominal, self.schedule

    @staticmethod
    def take_many(
        ticks: Ints, views: ManyViews, arrays: Sequence[Array], samples: Floats, first: int, end: int
    ) -> None:
        """Store the samples that are due in some worlds."""
        _take_many(ticks, views.numbers, samples, first, end, *arrays)


class OdometryKind(Kind):
    """The kind that serves `Odometry`."""

    declaration = Odometry
    sample_width = _WIDTH

    def stream(self, sensor: Fitted) -> str:
        """Return the stream of the encoders that it reads, so that it has their errors."""
        read = read_encoders(sensor.robot)
        return ODOMETRY_STREAM if read is None else str(read.id)

    def memory(self, _declaration: Odometry, /) -> int:
        """Return the size of the memory: that of the encoders, and the pose."""
        return COUNT_MEMORY + 5

    def compile(self, fitted: Sequence[Fitted], schedule: Ints, /) -> OdometryBlock:
        """Return the block."""
        robots = [sensor.robot for sensor in fitted]
        read = [read_encoders(robot) for robot in robots]
        figures = [
            encoder_figures(robot, 0.0 if one is None else one.drift) for robot, one in zip(robots, read, strict=True)
        ]
        nominal = [(math.pi * robot.wheel_diameter / robot.encoder_ticks, robot.track) for robot in robots]
        return OdometryBlock(np.array(figures, dtype=np.float64), np.array(nominal, dtype=np.float64), schedule)

    def written(self, _sensor: Fitted, /) -> Written:
        """Return the pose."""
        return Written((("x", DECIMAL), ("y", DECIMAL), ("heading", HEADING)))

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> OdometryReading:
        """Return the pose since joining, m and rad."""
        x, y, heading = sample
        return OdometryReading(id=sensor.declaration.id, tick=tick, x=x, y=y, heading=written_heading(heading))
