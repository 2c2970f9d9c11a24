"""Which part of a face a cone holds."""

from __future__ import annotations

import math
from typing import Any

import pytest

from intellwheels_server.world.kernels.sonar_faces import segment_in_wedge

# Type checkers count the arguments of a kernel and not those of a starred tuple.
SEGMENT: Any = segment_in_wedge


def test_nearest_point_of_a_segment_in_a_wedge() -> None:
    half = math.radians(30)
    cone = (1.0, 0.0, math.cos(half), math.sin(half))
    assert SEGMENT(2.0, -1.0, 2.0, 1.0, *cone) == pytest.approx((4.0, 2.0, 0.0))
    # From the left it begins where the left side of the wedge meets it.
    aside = 2.0 * math.tan(half)
    assert SEGMENT(2.0, 0.5, 2.0, 9.0, *cone)[0] == pytest.approx(4.25)
    assert SEGMENT(1.0, 3.0, 4.0, 0.0, *cone)[0] == pytest.approx(8.0 if half > math.pi / 4 else _crossing(half))
    assert SEGMENT(2.0, aside + 0.01, 2.0, 9.0, *cone)[0] == math.inf
    assert SEGMENT(-2.0, -1.0, -2.0, 1.0, *cone)[0] == math.inf
    assert SEGMENT(-2.0, -1.0, -2.0, 1.0, 1.0, 0.0, -1.0, 0.0)[0] == 4.0


def _crossing(half: float) -> float:
    """Return the square of the way along the left side to the line x + y = 4."""
    return (4.0 / (math.cos(half) + math.sin(half))) ** 2
