from __future__ import annotations

import math

import numpy as np

from intellwheels_server.world.kernels.rounded_readings import round_readings


def rounded(*numbers: float) -> list[float]:
    samples = np.array(numbers, dtype=np.float64)
    round_readings(np.array([[0, len(numbers)]]), samples)
    found: list[float] = samples.tolist()
    return found


def test_numbers_have_six_decimals_at_most() -> None:
    assert rounded(10.100000000000001, -1 / 3, 1234.56789012, 2.5e-7, 0.1 + 0.2) == [
        10.1, -0.333333, 1234.56789, 0.0, 0.3,
    ]  # fmt: skip


def test_zero_has_no_sign() -> None:
    assert [math.copysign(1.0, value) for value in rounded(-0.0, -1e-9, 0.0)] == [1.0, 1.0, 1.0]


def test_whole_numbers_and_codes_stay() -> None:
    counts = [0.0, -3.0, 5e9, 9007199254740991.0, -9007199254740991.0]
    assert rounded(*counts) == counts


def test_only_spans_are_rounded() -> None:
    samples = np.full(4, 1 / 3)
    round_readings(np.array([[1, 2], [3, 4]]), samples)
    assert samples.tolist() == [1 / 3, 0.333333, 1 / 3, 0.333333]
