"""The factor on a motor's output: standard normal, held for a time and not for a tick."""

from __future__ import annotations

import numpy as np
import pytest

from intellwheels_server.world.kernels.motor_noise import HOLD, interval_of, noise_factor
from intellwheels_server.world.kernels.noise import noise_key
from tests.every_case import every_case


def test_factor_has_its_standard_deviation_and_each_motor_its_own() -> None:
    flaws = np.array([[0.1], [0.0]])
    keys = np.array([[int(half.view(np.int64))] for half in noise_key("1", "a", "@motors")], dtype=np.int64)
    found = np.array([[noise_factor(flaws, keys, 0, interval, motor) for motor in (0, 1)] for interval in range(4000)])
    # All within four standard errors: sd/sqrt(n), sd/sqrt(2 n), 1/sqrt(n).
    assert found.mean(axis=0) == pytest.approx([1.0, 1.0], abs=4 * 0.1 / np.sqrt(4000))
    assert found.std(axis=0) == pytest.approx([0.1, 0.1], abs=4 * 0.1 / np.sqrt(8000))
    assert abs(np.corrcoef(found.T)[0, 1]) < 4 / np.sqrt(4000)
    assert abs(np.corrcoef(found[1:, 0], found[:-1, 0])[0, 1]) < 4 / np.sqrt(4000)


@every_case("period", [0.001, 0.01, 0.02, 0.05, 0.1, 0.2, 0.03, 0.007])
def test_intervals_begin_at_the_same_times_whatever_the_tick(period: float) -> None:
    for edge in (*range(1, 400), 2_000_000):
        tick = round(edge * HOLD / period)
        if abs(tick * period - edge * HOLD) < 1e-9:
            assert interval_of(tick, period) == edge
    assert interval_of(7, HOLD) == 7.0
