"""A body as circles: its distance to points, at a pose and over the lattice."""

from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_agents.navigation.body_circles import BodyCircles
from intellwheels_agents.navigation.cost_to_go import distances
from intellwheels_agents.navigation.footprint_clearance import Box, Frame
from intellwheels_agents.navigation.lattice import ANGLES

CIRCLES = BodyCircles([Box(0.8, -0.3, 0.3, -0.3, 0.0, 1.0)])


@pytest.mark.parametrize(
    ("point", "gap"), [((1.2, 0.0), 0.4), ((0.5, 0.7), 0.4), ((-0.5, 0.0), 0.2), ((0.5, 0.0), -0.3)]
)
def test_distance_to_a_point(point: tuple[float, float], gap: float) -> None:
    # Between two circles the body seems at most 2 cm narrower.
    assert CIRCLES.gap((0.0, 0.0, 0.0), np.array([point])) == pytest.approx(gap, abs=0.02)
    turned = np.array([(2.0 - point[1], 1.0 + point[0])])
    assert CIRCLES.gap((2.0, 1.0, math.pi / 2.0), turned) == pytest.approx(gap, abs=0.02)


def test_without_points_all_is_far() -> None:
    assert CIRCLES.gap((0.0, 0.0, 0.0), np.zeros((0, 2))) == math.inf


@pytest.mark.parametrize("heading", [0, 8, 13])
def test_gaps_over_cells_are_those_of_the_poses(heading: int) -> None:
    frame = Frame(0.0, 0.0, 0.1, 40, 40)
    gaps = CIRCLES.gaps(distances(frame, [(2.0, 2.0)]), frame, heading)
    for row, column in ((5, 20), (20, 30), (33, 8)):
        pose = 0.1 * column, 0.1 * row, float(ANGLES[heading])
        assert gaps[row, column] == pytest.approx(CIRCLES.gap(pose, np.array([(2.0, 2.0)])), abs=0.08)
