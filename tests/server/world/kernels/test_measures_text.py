from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from intellwheels_schemas.shapes import number_text
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.measures_text import write_measures


@given(st.integers(-(10**15), 10**15))
def test_numbers_are_written_as_the_codec_writes_them(millionths: int) -> None:
    value = millionths / 1e6 + 0.0
    assert _written(value) == (number_text(value) if abs(value) < 1e9 else "")


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -0.0, 0.1 + 0.2, 1e-7, 1e300])
def test_numbers_that_are_no_rounded_ones_are_left_to_the_codec(value: float) -> None:
    assert _written(value) == ""


def _written(value: float) -> str:
    """Return what the kernel writes of a sensor whose reading is a number alone; nothing if it refuses."""
    sensors = np.array([[0, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0]])
    readers = np.array([[0], [0], [0], [0], [1], [0], [0]])
    steps = np.array([[0, 0, 2, 0], [0, 0, 0, 0]])
    out, ends = np.zeros(99, np.uint8), np.zeros(2, np.int64)
    empty = np.frombuffer(b"", np.uint8)
    write_measures(
        0, False, empty, empty, readers, sensors, np.array([0, 0]), steps, np.zeros((30, 2), np.int64), empty,
        np.zeros((rows.FLAG_ROWS, 1), np.int64), np.zeros((rows.NUMBER_ROWS, 1)), np.array([value]), out, ends,
    )  # fmt: skip
    return out[: ends[1]].tobytes().decode()
