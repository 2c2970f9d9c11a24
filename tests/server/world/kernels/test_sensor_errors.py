"""Biases that walk: by the square root of time, once a tick, from 0."""

from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.noise import noise_key
from intellwheels_server.world.kernels.sample_schedule import DEPTH, EVERY, FIRST_SAMPLE, KEY0, KEY1, SCHEDULE_COLUMNS
from intellwheels_server.world.kernels.sensor_errors import BIAS_MEMORY, memory_of, spoilt, walk


def _sensors(count: int) -> tuple[Ints, Floats]:
    rows = np.zeros((count, SCHEDULE_COLUMNS), dtype=np.int64)
    rows[:, EVERY] = rows[:, DEPTH] = 1
    rows[:, FIRST_SAMPLE] = np.arange(count) * (1 + BIAS_MEMORY)
    for k in range(count):
        rows[k, KEY0], rows[k, KEY1] = (int(half.view(np.int64)) for half in noise_key("1", f"a{k}", "s"))
    return rows, np.zeros(count * (1 + BIAS_MEMORY))


def _walked(period: float, seconds: float, count: int = 2000) -> Floats:
    rows, samples = _sensors(count)
    for tick in range(round(seconds / period) + 1):
        for sensor in range(count):
            walk(rows, sensor, tick, 1, 1, 0.3, 0.0, period, samples)
    return samples[2 :: 1 + BIAS_MEMORY]


@pytest.mark.parametrize("period", [0.5, 0.1])
def test_bias_grows_with_the_root_of_time_whatever_the_tick(period: float) -> None:
    found = _walked(period, 4.0)
    assert found.std() == pytest.approx(0.6, rel=0.05)
    assert abs(found.mean()) < 4 * 0.6 / math.sqrt(len(found))


def test_bias_steps_once_a_tick_and_not_at_its_first() -> None:
    rows, samples = _sensors(1)
    walk(rows, 0, 7, 1, 1, 0.3, 0.0, 0.05, samples)
    assert samples[memory_of(rows, 0, 1) + 1] == 0.0
    walk(rows, 0, 8, 1, 1, 0.3, 0.0, 0.05, samples)
    once = samples.copy()
    walk(rows, 0, 8, 1, 1, 0.3, 0.0, 0.05, samples)
    assert once[memory_of(rows, 0, 1) + 1] != 0.0
    assert samples.tolist() == once.tolist()


def test_value_is_clipped_and_then_rounded_to_steps_within_the_bound() -> None:
    rows, samples = _sensors(1)
    for true, step, expected in (
        (1.24, 0.5, 1.0),
        (1.26, 0.5, 1.5),
        (99.0, 0.0, 10.0),
        (9.9, 4.0, 8.0),
        (-9.9, 4.0, -8.0),
    ):
        assert spoilt(true, rows, 0, 3, 1, 0, False, 0.0, step, 10.0, samples) == expected
