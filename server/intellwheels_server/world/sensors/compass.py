"""Compasses: the heading, with Gaussian noise and, if declared, a random walk of the bias and quantisation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from intellwheels_schemas.messages import Compass, CompassReading
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.elementary import wrap
from intellwheels_server.world.kernels.measures_text import HEADING
from intellwheels_server.world.kernels.noise import normal
from intellwheels_server.world.kernels.sample_schedule import BODY, KEY0, KEY1, due_slot
from intellwheels_server.world.kernels.sensor_errors import BIAS_MEMORY, memory_of, walk
from intellwheels_server.world.sensors.angles import written_heading
from intellwheels_server.world.sensors.kind import Fitted, Kind, View, Written

# Columns of the settings, float64[sensors, 3], rad.
_SIGMA, _STEP, _WALK = 0, 1, 2


@njit(cache=True, error_model="numpy")
def _take(tick: int, period: float, numbers: Floats, settings: Floats, schedule: Ints, samples: Floats) -> None:
    for sensor in range(schedule.shape[0]):
        if settings[sensor, _WALK] > 0.0:
            walk(schedule, sensor, tick, 1, 1, settings[sensor, _WALK], 0.0, period, samples)
        slot = due_slot(schedule, sensor, tick, 1)
        if slot < 0:
            continue
        heading = numbers[rows.HEADING, schedule[sensor, BODY]]
        sigma = settings[sensor, _SIGMA]
        step = settings[sensor, _STEP]
        if settings[sensor, _WALK] > 0.0:
            heading = wrap(heading + samples[memory_of(schedule, sensor, 1) + 1])
        if sigma > 0.0:
            key0 = np.uint64(schedule[sensor, KEY0])
            key1 = np.uint64(schedule[sensor, KEY1])
            heading = wrap(heading + sigma * normal(key0, key1, tick, 0))
        if step > 0.0:
            heading = wrap(step * np.floor(heading / step + 0.5))
        samples[slot] = heading


@dataclass(frozen=True)
class CompassBlock:
    """All compasses."""

    settings: Floats
    schedule: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.period, view.numbers, self.settings, self.schedule, samples)


class CompassKind(Kind):
    """The kind that serves `Compass`."""

    declaration = Compass

    def memory(self, declaration: Compass, /) -> int:
        """Return the memory of the random walk of the bias, if it has one."""
        return BIAS_MEMORY if declaration.walk_deg > 0.0 else 0

    def compile(self, fitted: Sequence[Fitted], schedule: Ints, /) -> CompassBlock:
        """Return the block."""
        degrees = [(one.declaration.noise_deg, one.declaration.step_deg, one.declaration.walk_deg) for one in fitted]
        return CompassBlock(np.array(degrees, dtype=np.float64) * (math.pi / 180.0), schedule)

    def written(self, _sensor: Fitted, /) -> Written:
        """Return the heading."""
        return Written((("value", HEADING),))

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> CompassReading:
        """Return the heading, rad."""
        return CompassReading(id=sensor.declaration.id, tick=tick, value=written_heading(sample[0]))
