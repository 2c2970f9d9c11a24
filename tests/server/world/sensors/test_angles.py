"""Unit vectors of angles in degrees."""

from __future__ import annotations

import math

import pytest

from intellwheels_server.world.sensors.angles import unit_vector


def test_direction_to_the_side_is_exactly_to_the_side() -> None:
    assert [unit_vector(degrees) for degrees in (0.0, 90.0, -90.0, 180.0, -180.0, 360.0)] == [
        (1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (-1.0, 0.0), (-1.0, 0.0), (1.0, 0.0),
    ]  # fmt: skip
    assert unit_vector(30.0) == pytest.approx((math.sqrt(0.75), 0.5), abs=1e-15)
