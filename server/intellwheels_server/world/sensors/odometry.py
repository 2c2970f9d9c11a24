"""Odometry: the pose since joining, integrated tick by tick from the encoders' counts with the nominal figures.

It begins at (0, 0, 0), where the body joined and as it stood. It reads the robot's first simulated encoders and errs as
they do, by the same noise; a robot without any has perfect ones.

Source:
    Drift with a variance of k metres a metre and wheel: sd(heading) = sqrt(2 k L) / b after L metres straight on, and
    sd(aside) = sqrt(2 k L^3 / 3) / b, b the track.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit

from intellwheels_schemas.messages import Encoders, Odometry, OdometryReading, Robot
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.bias import memory_of
from intellwheels_server.world.kernels.geometry import arc
from intellwheels_server.world.kernels.rows import WORLD_EDGE
from intellwheels_server.world.kernels.timetable import due_slot
from intellwheels_server.world.sensors.encoders import LEFT_COUNT, MEMORY, RIGHT_COUNT, count_rolled, encoder_figures
from intellwheels_server.world.sensors.kind import Fitted, View

ODOMETRY_STREAM: Final = "@odometry"
"""The noise stream of odometry without encoders; no sensor's id can begin so."""

_WIDTH = 3
# Behind what the encoders remember: the counts that are in the pose, and the pose.
_LEFT_USED, _RIGHT_USED, _X, _Y, _HEADING = MEMORY, MEMORY + 1, MEMORY + 2, MEMORY + 3, MEMORY + 4
# Columns of the nominal figures, float64[sensors, 2]: metres a tick, track in metres.
_WAY, _TRACK = 0, 1


def read_encoders(robot: Robot) -> Encoders | None:
    """Return the encoders that a robot's odometry reads, None for perfect ones."""
    return next((one for one in robot.encoders if one.source == "simulated"), None)


@njit(cache=True, error_model="numpy")
def _take(tick: int, numbers: Floats, figures: Floats, nominal: Floats, timetable: Ints, samples: Floats) -> None:
    for sensor in range(timetable.shape[0]):
        place = memory_of(timetable, sensor, _WIDTH)
        count_rolled(tick, numbers, figures, timetable, sensor, place, samples)
        left = (samples[place + LEFT_COUNT] - samples[place + _LEFT_USED]) * nominal[sensor, _WAY]
        right = (samples[place + RIGHT_COUNT] - samples[place + _RIGHT_USED]) * nominal[sensor, _WAY]
        samples[place + _LEFT_USED] = samples[place + LEFT_COUNT]
        samples[place + _RIGHT_USED] = samples[place + RIGHT_COUNT]
        if left != 0.0 or right != 0.0:
            x, y, heading, _, _ = arc(
                samples[place + _X], samples[place + _Y], samples[place + _HEADING], 0.5 * (left + right),
                (right - left) / nominal[sensor, _TRACK],
            )  # fmt: skip
            samples[place + _X] = min(max(x, -WORLD_EDGE), WORLD_EDGE)
            samples[place + _Y] = min(max(y, -WORLD_EDGE), WORLD_EDGE)
            samples[place + _HEADING] = heading
        slot = due_slot(timetable, sensor, tick, _WIDTH)
        if slot >= 0:
            for at in range(_WIDTH):
                samples[slot + at] = samples[place + _X + at]


@dataclass(frozen=True)
class OdometryBlock:
    """All odometry."""

    figures: Floats
    nominal: Floats
    timetable: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.numbers, self.figures, self.nominal, self.timetable, samples)


class OdometryKind:
    """The kind that serves `Odometry`."""

    field = "odometry"

    def check(self, where: str, declaration: Odometry, robot: Robot) -> None:
        """Refuse none."""

    def width(self, declaration: Odometry) -> int:  # noqa: ARG002 - as `Kind` has it
        """Return the numbers in a sample."""
        return _WIDTH

    def memory(self, declaration: Odometry) -> int:  # noqa: ARG002 - as `Kind` has it
        """Return the room of what the encoders remember, and of the pose."""
        return MEMORY + 5

    def compile(self, fitted: Sequence[Fitted], timetable: Ints) -> OdometryBlock:
        """Return the block."""
        robots = [sensor.robot for sensor in fitted]
        read = [read_encoders(robot) for robot in robots]
        figures = [
            encoder_figures(robot, 0.0 if one is None else one.drift) for robot, one in zip(robots, read, strict=True)
        ]
        nominal = [(math.pi * robot.wheel_diameter / robot.encoder_ticks, robot.track) for robot in robots]
        return OdometryBlock(np.array(figures, dtype=np.float64), np.array(nominal, dtype=np.float64), timetable)

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> OdometryReading:
        """Return the pose since joining, m and rad."""
        x, y, heading = sample
        return OdometryReading(id=sensor.declaration.id, tick=tick, x=x, y=y, heading=heading)
