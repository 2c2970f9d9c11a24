"""Inertial units: acceleration of the centre of movement along and across, and turn rate, each with its own bias.

The forward acceleration is the change of speed in the last tick over the period. The acceleration to the left is speed
times turn rate. At the first tick there is no earlier speed, and the forward acceleration is 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from intellwheels_schemas.messages import IMU, IMUReading
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.measures_text import DECIMAL
from intellwheels_server.world.kernels.noise import normal
from intellwheels_server.world.kernels.sample_schedule import BODY, KEY0, KEY1, due_slot
from intellwheels_server.world.kernels.sensor_errors import BIAS_MEMORY, memory_of, spoilt, walk
from intellwheels_server.world.sensors.kind import Fitted, Kind, View, Written

# Columns of the settings, float64[sensors, 6].
_SIGMA, _STEP, _WALK, _TURN_SIGMA, _TURN_STEP, _TURN_WALK = 0, 1, 2, 3, 4, 5
_WIDTH = 3
# Largest value of a message, m/s2.
_MOST = 1000.0
# Behind the biases: the speed at the last tick and at the one before, and the last tick, from 1.
_LAST, _BEFORE, _AT = BIAS_MEMORY, BIAS_MEMORY + 1, BIAS_MEMORY + 2
# Behind them the bias of the acceleration to the left, for units whose accelerations have biases.
_LEFT_BIAS = BIAS_MEMORY + 3
# Draws of the acceleration to the left, behind those of `sensor_errors`: noise, and the step of the bias.
_LEFT_DRAW, _LEFT_WALK_DRAW = 4, 5


@njit(cache=True, error_model="numpy")
def _take(tick: int, period: float, numbers: Floats, settings: Floats, schedule: Ints, samples: Floats) -> None:
    for sensor in range(schedule.shape[0]):
        body = schedule[sensor, BODY]
        place = memory_of(schedule, sensor, _WIDTH)
        speed = numbers[rows.SPEED, body]
        if samples[place + _AT] != tick + 1.0:
            samples[place + _BEFORE] = samples[place + _LAST] if samples[place + _AT] > 0.0 else speed
            samples[place + _AT] = tick + 1.0
        samples[place + _LAST] = speed
        key0, key1 = np.uint64(schedule[sensor, KEY0]), np.uint64(schedule[sensor, KEY1])
        walks = settings[sensor, _WALK]
        if walks > 0.0 and samples[place] != 0.0 and samples[place] != tick + 1.0:
            samples[place + _LEFT_BIAS] += walks * math.sqrt(period) * normal(key0, key1, tick, _LEFT_WALK_DRAW)
        walk(schedule, sensor, tick, _WIDTH, 2, walks, settings[sensor, _TURN_WALK], period, samples)
        slot = due_slot(schedule, sensor, tick, _WIDTH)
        if slot < 0:
            continue
        turn_rate = numbers[rows.TURN_RATE, body]
        sigma, step = settings[sensor, _SIGMA], settings[sensor, _STEP]
        samples[slot] = spoilt(
            (speed - samples[place + _BEFORE]) / period, schedule, sensor, tick, _WIDTH, 0, True, sigma, step, _MOST,
            samples,
        )  # fmt: skip
        left = speed * turn_rate
        if sigma > 0.0:
            left += sigma * normal(key0, key1, tick, _LEFT_DRAW)
        if walks > 0.0:
            left += samples[place + _LEFT_BIAS]
        samples[slot + 1] = spoilt(left, schedule, sensor, tick, _WIDTH, 0, False, 0.0, step, _MOST, samples)
        samples[slot + 2] = spoilt(
            turn_rate, schedule, sensor, tick, _WIDTH, 1, True, settings[sensor, _TURN_SIGMA],
            settings[sensor, _TURN_STEP], rows.MOST_TURN_RATE, samples,
        )  # fmt: skip


@dataclass(frozen=True)
class IMUBlock:
    """All inertial units."""

    settings: Floats
    schedule: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.period, view.numbers, self.settings, self.schedule, samples)


class IMUKind(Kind):
    """The kind that serves `IMU`."""

    declaration = IMU
    sample_width = _WIDTH

    def memory(self, declaration: IMU, /) -> int:
        """Return the size of the memory: biases and speeds."""
        return BIAS_MEMORY + (4 if declaration.walk > 0.0 else 3)

    def compile(self, fitted: Sequence[Fitted], schedule: Ints, /) -> IMUBlock:
        """Return the block."""
        ones: list[IMU] = [sensor.declaration for sensor in fitted]
        settings = [(one.noise, one.step, one.walk, one.turn_noise, one.turn_step, one.turn_walk) for one in ones]
        return IMUBlock(np.array(settings, dtype=np.float64), schedule)

    def written(self, _sensor: Fitted, /) -> Written:
        """Return accelerations and turn rate."""
        return Written((("forward", DECIMAL), ("left", DECIMAL), ("turn_rate", DECIMAL)))

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> IMUReading:
        """Return accelerations, m/s2, and turn rate, rad/s."""
        forward, left, turn_rate = sample
        return IMUReading(id=sensor.declaration.id, tick=tick, forward=forward, left=left, turn_rate=turn_rate)
