from __future__ import annotations

import math

import numpy as np

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.motor_model import MOTOR_ROWS
from intellwheels_server.world.kernels.state_text import STATES, write_entities


def written(numbers: dict[int, float], length: float = math.nan) -> str | None:
    """Return a body without a name and without fixed bytes: nothing but its numbers, one behind the other."""
    block = np.zeros((rows.NUMBER_ROWS, 1))
    for row, value in numbers.items():
        block[row] = value
    out, ends, none = np.zeros(999, np.uint8), np.zeros(2, np.int64), np.frombuffer(b"", np.uint8)
    done = write_entities(
        none, np.zeros(2, np.int64), none, np.zeros((STATES + 6, 2), np.int64), none, np.zeros(2, np.int64),
        np.zeros(1), np.array([[length], [0.0]]), np.zeros((MOTOR_ROWS, 1)),
        np.zeros((rows.FLAG_ROWS, 1), np.int64), block, out, ends,
    )  # fmt: skip
    return out[: ends[1]].tobytes().decode() if done else None


def test_numbers_are_rounded_and_defaults_are_left_out() -> None:
    assert written({rows.X: 1.23456789, rows.Y: -1e-7}) == "1.2345680.00.0"
    assert written({rows.SPEED: 4e-7}) == "0.00.00.0"
    assert written({rows.SPEED: -0.5}, length=2.0) == "0.00.00.0-0.52.00.0"


def test_a_heading_that_rounding_takes_beyond_half_a_turn_is_half_a_turn() -> None:
    assert written({rows.HEADING: math.pi}) == "0.00.03.141592653589793"


def test_a_number_that_is_too_long_is_refused() -> None:
    assert written({rows.X: 1e12}) is None
    assert written({rows.X: math.nan}) is None
