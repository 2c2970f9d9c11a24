"""Wheel encoders: whole ticks of both wheels since joining, forward positive."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from intellwheels_schemas.messages import MAX_INTEGER, Encoders, EncodersReading, Robot
from intellwheels_server.kernels.arrays import Floats, Ints
from intellwheels_server.kernels.rows import LEFT_TRAVEL, RIGHT_TRAVEL
from intellwheels_server.kernels.timetable import BODY, due_slot
from intellwheels_server.sensors.kind import Fitted, View

# The largest count of the wire; a wheel of a nanometre would soon be beyond.
_MOST = float(MAX_INTEGER)


@njit(cache=True, error_model="numpy")
def _take(tick: int, numbers: Floats, ticks_per_metre: Floats, timetable: Ints, samples: Floats) -> None:
    for sensor in range(timetable.shape[0]):
        slot = due_slot(timetable, sensor, tick, 2)
        if slot < 0:
            continue
        body = timetable[sensor, BODY]
        # Rounded, not cut: a wheel that is back where it was within rounding counts what it counted there.
        left = np.floor(numbers[LEFT_TRAVEL, body] * ticks_per_metre[sensor] + 0.5)
        right = np.floor(numbers[RIGHT_TRAVEL, body] * ticks_per_metre[sensor] + 0.5)
        samples[slot] = min(max(left, -_MOST), _MOST)
        samples[slot + 1] = min(max(right, -_MOST), _MOST)


@dataclass(frozen=True)
class EncodersBlock:
    """All encoders."""

    ticks_per_metre: Floats
    timetable: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.numbers, self.ticks_per_metre, self.timetable, samples)


class EncodersKind:
    """The kind that serves `Encoders`."""

    field = "encoders"
    width = 2

    def check(self, where: str, declaration: Encoders, robot: Robot) -> None:
        """Refuse none."""

    def compile(self, fitted: Sequence[Fitted], timetable: Ints) -> EncodersBlock:
        """Return the block."""
        robots = [sensor.robot for sensor in fitted]
        ticks = [min(robot.encoder_ticks / (math.pi * robot.wheel_diameter), _MOST) for robot in robots]
        return EncodersBlock(np.array(ticks, dtype=np.float64), timetable)

    def reading(self, declaration: Encoders, tick: int | None, sample: Sequence[float]) -> EncodersReading:
        """Return the counts."""
        return EncodersReading(id=declaration.id, tick=tick, left=int(sample[0]), right=int(sample[1]))
