"""The nearest point of a segment in a wedge, and between two rays."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from intellwheels_server.world.kernels.sonar_faces import is_inside, segment_between, segment_in_wedge, sides_of_box

# Type checkers count the arguments of a kernel and not those of a starred tuple.
SEGMENT: Any = segment_in_wedge
BETWEEN: Any = segment_between


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


def test_nearest_point_of_a_segment_between_two_rays() -> None:
    rays = (2.0, -2.0, 3.0, 3.0)
    assert BETWEEN(2.0, -1.0, 2.0, 1.0, *rays) == pytest.approx((4.0, 2.0, 0.0))
    assert BETWEEN(2.0, 1.0, 2.0, 9.0, *rays) == pytest.approx((5.0, 2.0, 1.0))
    assert BETWEEN(0.0, 3.0, 3.0, 0.0, *rays) == pytest.approx((4.5, 1.5, 1.5))
    assert BETWEEN(0.0, 3.0, 1.0, 3.0, *rays)[0] == math.inf
    assert BETWEEN(-2.0, -1.0, -2.0, 1.0, *rays)[0] == math.inf


def test_nearest_points_agree_with_a_fine_cut_of_the_segment() -> None:
    draw = np.random.default_rng(5)
    for _ in range(50):
        px, py, qx, qy = (float(one) for one in draw.uniform(-3.0, 3.0, 4))
        turn, half = float(draw.uniform(-math.pi, math.pi)), float(draw.uniform(0.1, 1.4))
        right = (math.cos(turn - half), math.sin(turn - half))
        left = (math.cos(turn + half), math.sin(turn + half))
        share = np.linspace(0.0, 1.0, 4001)
        x, y = px + share * (qx - px), py + share * (qy - py)
        held = (right[0] * y - right[1] * x >= 0.0) & (x * left[1] - y * left[0] >= 0.0)
        finest = float(np.where(held, x * x + y * y, np.inf).min())
        for square in (
            BETWEEN(px, py, qx, qy, *right, *left)[0],
            SEGMENT(px, py, qx, qy, math.cos(turn), math.sin(turn), math.cos(half), math.sin(half))[0],
        ):
            assert square == pytest.approx(finest, abs=0.02) or not held.any() or held.sum() < 5


def test_inside_of_a_box() -> None:
    boxes = np.array([[1.0, 2.0, 0.5, 0.5, 0.0, 1.0, 0.8, 0.6, 0.4, 0.3]])
    sides = np.empty((4, 6))
    for x, y, inside in ((1.0, 2.0, True), (1.3, 2.2, True), (1.4, 2.3, False), (0.0, 0.0, False)):
        assert is_inside(sides, sides_of_box(boxes, 0, x, y, sides)) == inside
