"""Wheel encoders: whole ticks of both wheels since joining, forward positive.

They count the turns of the true wheels: a wheel larger than the nominal one turns less for the same distance. With
`Drift` k the distance that a wheel counts has a normal error of variance k per metre rolled, from slip and uneven
ground. The variance grows with the distance alone, so it does not depend on the period.

Source:
    Borenstein and Feng (1996), Measurement and correction of systematic odometry errors in mobile robots, IEEE
    Transactions on Robotics and Automation 12(6): E_d, right wheel over left one at the same mean, and E_b.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from intellwheels_schemas.messages import MAX_INTEGER, Encoders, EncodersReading, Robot
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.measures_text import WHOLE
from intellwheels_server.world.kernels.motor_model import wheel_scales
from intellwheels_server.world.kernels.noise import normal
from intellwheels_server.world.kernels.sample_schedule import BODY, KEY0, KEY1, due_slot
from intellwheels_server.world.kernels.sensor_errors import memory_of
from intellwheels_server.world.sensors.kind import Array, Fitted, Kind, ManyViews, View, Written

# The largest count that a message can carry. A wheel of a nanometre would soon exceed it.
_MOST = float(MAX_INTEGER)

# Columns of the figures, float64[sensors, 3]: ticks per metre of the true left and right wheel; variance per metre, m.
_LEFT, _RIGHT, _DRIFT = 0, 1, 2

# Memory of encoders, from `memory_of` on: distances for which errors were drawn, m; errors, m; counts.
LEFT_COVERED, RIGHT_COVERED, LEFT_ERROR, RIGHT_ERROR, LEFT_COUNT, RIGHT_COUNT = 0, 1, 2, 3, 4, 5
COUNT_MEMORY = 6


@njit(cache=True, error_model="numpy")
def count_rolled(
    tick: int, numbers: Floats, figures: Floats, schedule: Ints, sensor: int, place: int, samples: Floats
) -> None:
    """Update the memory of a sensor to the distances that its wheels have rolled. A repetition changes nothing.

    Args:
        tick: The tick.
        numbers: Of the bodies.
        figures: float64[sensors, 3], as `encoder_figures` gives them.
        schedule: int64[sensors, 8].
        sensor: Row of the schedule and of the figures.
        place: Index of its memory.
        samples: float64[...], in and out.
    """
    body = schedule[sensor, BODY]
    drift = figures[sensor, _DRIFT]
    for wheel in range(2):
        way = numbers[rows.LEFT_TRAVEL if wheel == 0 else rows.RIGHT_TRAVEL, body]
        if drift > 0.0:
            rolled = abs(way - samples[place + LEFT_COVERED + wheel])
            if rolled > 0.0:
                key0, key1 = np.uint64(schedule[sensor, KEY0]), np.uint64(schedule[sensor, KEY1])
                error = math.sqrt(drift * rolled) * normal(key0, key1, tick, wheel)
                samples[place + LEFT_ERROR + wheel] += error
                samples[place + LEFT_COVERED + wheel] = way
            way += samples[place + LEFT_ERROR + wheel]
        # Rounded, not truncated: a wheel that returns to an angle, within rounding, returns to its count.
        count = np.floor(way * figures[sensor, _LEFT + wheel] + 0.5)
        samples[place + LEFT_COUNT + wheel] = min(max(count, -_MOST), _MOST)


@njit(cache=True, error_model="numpy")
def _take(tick: int, numbers: Floats, figures: Floats, schedule: Ints, samples: Floats) -> None:
    for sensor in range(schedule.shape[0]):
        place = memory_of(schedule, sensor, 2)
        count_rolled(tick, numbers, figures, schedule, sensor, place, samples)
        slot = due_slot(schedule, sensor, tick, 2)
        if slot >= 0:
            samples[slot] = samples[place + LEFT_COUNT]
            samples[slot + 1] = samples[place + RIGHT_COUNT]


@njit(cache=True, error_model="numpy", nogil=True)
def _take_many(
    ticks: Ints, numbers: Floats, samples: Floats, first: int, end: int, figures: Floats, schedule: Ints
) -> None:  # fmt: skip
    """Store the samples of some worlds, of which every array has a row each."""
    for world in range(first, end):
        _take(ticks[world], numbers[world], figures[world], schedule[world], samples[world])


def encoder_figures(robot: Robot, drift: float) -> tuple[float, float, float]:
    """Return the ticks per metre of the true left and right wheel, and the variance per metre, m."""
    left, right = wheel_scales(robot.wheel_ratio, robot.wheel_scale)
    return (
        min(robot.encoder_ticks / (math.pi * max(robot.wheel_diameter * left, 5e-324)), _MOST),
        min(robot.encoder_ticks / (math.pi * max(robot.wheel_diameter * right, 5e-324)), _MOST),
        drift,
    )


@dataclass(frozen=True)
class EncodersBlock:
    """All encoders."""

    figures: Floats
    schedule: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.numbers, self.figures, self.schedule, samples)

    def stackable(self) -> tuple[Array, ...]:
        """Return the arrays that `take_many` needs."""
        return self.figures, self.schedule

    @staticmethod
    def take_many(
        ticks: Ints, views: ManyViews, arrays: Sequence[Array], samples: Floats, first: int, end: int
    ) -> None:
        """Store the samples that are due in some worlds."""
        _take_many(ticks, views.numbers, samples, first, end, *arrays)


class EncodersKind(Kind):
    """The kind that serves `Encoders`."""

    declaration = Encoders
    sample_width = 2

    def memory(self, _declaration: Encoders, /) -> int:
        """Return the size of the memory: errors and counts."""
        return COUNT_MEMORY

    def compile(self, fitted: Sequence[Fitted], schedule: Ints, /) -> EncodersBlock:
        """Return the block."""
        figures = [encoder_figures(sensor.robot, sensor.declaration.drift) for sensor in fitted]
        return EncodersBlock(np.array(figures, dtype=np.float64), schedule)

    def written(self, _sensor: Fitted, /) -> Written:
        """Return the counts."""
        return Written((("left", WHOLE), ("right", WHOLE)))

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> EncodersReading:
        """Return the counts."""
        return EncodersReading(id=sensor.declaration.id, tick=tick, left=int(sample[0]), right=int(sample[1]))
