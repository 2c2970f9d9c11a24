"""GPS: the position of a point of the body, with Gaussian noise, a random walk of the bias, and quantisation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from intellwheels_schemas.messages import GPS, GPSReading
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.measures_text import DECIMAL
from intellwheels_server.world.kernels.sample_schedule import BODY, due_slot
from intellwheels_server.world.kernels.sensor_errors import BIAS_MEMORY, spoilt, walk
from intellwheels_server.world.sensors.kind import Fitted, Kind, View, Written

# Columns of the settings, float64[sensors, 5]: the point, then m.
_X, _Y, _SIGMA, _STEP, _WALK = 0, 1, 2, 3, 4


@njit(cache=True, error_model="numpy")
def _take(tick: int, period: float, numbers: Floats, settings: Floats, schedule: Ints, samples: Floats) -> None:
    for sensor in range(schedule.shape[0]):
        if settings[sensor, _WALK] > 0.0:
            walk(schedule, sensor, tick, 2, 2, settings[sensor, _WALK], settings[sensor, _WALK], period, samples)
        slot = due_slot(schedule, sensor, tick, 2)
        if slot < 0:
            continue
        body = schedule[sensor, BODY]
        s, c = sincos(numbers[rows.HEADING, body])
        a, b = settings[sensor, _X], settings[sensor, _Y]
        for axis in range(2):
            true = numbers[rows.X, body] + (c * a - s * b) if axis == 0 else numbers[rows.Y, body] + (s * a + c * b)
            samples[slot + axis] = spoilt(
                true, schedule, sensor, tick, 2, axis, settings[sensor, _WALK] > 0.0, settings[sensor, _SIGMA],
                settings[sensor, _STEP], rows.WORLD_EDGE, samples,
            )  # fmt: skip


@dataclass(frozen=True)
class GPSBlock:
    """All GPS receivers."""

    settings: Floats
    schedule: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.period, view.numbers, self.settings, self.schedule, samples)


class GPSKind(Kind):
    """The kind that serves `GPS`."""

    declaration = GPS
    sample_width = 2

    def memory(self, declaration: GPS, /) -> int:
        """Return the memory of the random walk of the bias, if it has one."""
        return BIAS_MEMORY if declaration.walk > 0.0 else 0

    def compile(self, fitted: Sequence[Fitted], schedule: Ints, /) -> GPSBlock:
        """Return the block."""
        ones: list[GPS] = [sensor.declaration for sensor in fitted]
        settings = [(one.x, one.y, one.noise, one.step, one.walk) for one in ones]
        return GPSBlock(np.array(settings, dtype=np.float64), schedule)

    def written(self, _sensor: Fitted, /) -> Written:
        """Return the position."""
        return Written((("x", DECIMAL), ("y", DECIMAL)))

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> GPSReading:
        """Return the position on the map, m."""
        return GPSReading(id=sensor.declaration.id, tick=tick, x=sample[0], y=sample[1])
