"""Compasses: the heading, with Gaussian noise and a quantisation step if declared."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from intellwheels_schemas.messages import Compass, CompassReading, Robot
from intellwheels_server.kernels.arrays import Floats, Ints
from intellwheels_server.kernels.elementary import wrap
from intellwheels_server.kernels.noise import normal
from intellwheels_server.kernels.rows import HEADING
from intellwheels_server.kernels.timetable import BODY, KEY0, KEY1, due_slot
from intellwheels_server.sensors.kind import Fitted, View

# Columns of the settings, float64[sensors, 2], rad.
_SIGMA, _STEP = 0, 1


@njit(cache=True, error_model="numpy")
def _take(tick: int, numbers: Floats, settings: Floats, timetable: Ints, samples: Floats) -> None:
    for sensor in range(timetable.shape[0]):
        slot = due_slot(timetable, sensor, tick, 1)
        if slot < 0:
            continue
        heading = numbers[HEADING, timetable[sensor, BODY]]
        sigma = settings[sensor, _SIGMA]
        step = settings[sensor, _STEP]
        if sigma > 0.0:
            key0 = np.uint64(timetable[sensor, KEY0])
            key1 = np.uint64(timetable[sensor, KEY1])
            heading = wrap(heading + sigma * normal(key0, key1, tick, 0))
        if step > 0.0:
            heading = wrap(step * np.floor(heading / step + 0.5))
        samples[slot] = heading


@dataclass(frozen=True)
class CompassBlock:
    """All compasses."""

    settings: Floats
    timetable: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.numbers, self.settings, self.timetable, samples)


class CompassKind:
    """The kind that serves `Compass`."""

    field = "compass"
    width = 1

    def check(self, where: str, declaration: Compass, robot: Robot) -> None:
        """Refuse none."""

    def compile(self, fitted: Sequence[Fitted], timetable: Ints) -> CompassBlock:
        """Return the block."""
        degrees = [(sensor.declaration.noise_deg, sensor.declaration.step_deg) for sensor in fitted]
        return CompassBlock(np.array(degrees, dtype=np.float64) * (math.pi / 180.0), timetable)

    def reading(self, declaration: Compass, tick: int | None, sample: Sequence[float]) -> CompassReading:
        """Return the heading, rad."""
        return CompassReading(id=declaration.id, tick=tick, value=sample[0])
