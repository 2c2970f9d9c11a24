"""Distances are those of shapely, at the sensor's height."""

from __future__ import annotations

import random

import numpy as np
import pytest
import shapely

from intellwheels_agents.navigation.footprint_clearance import solids_of
from intellwheels_agents.navigation.map_distance import CELL, FARTHEST, MapDistance
from intellwheels_maps import floor


def test_distances_agree_with_shapely() -> None:
    solids = solids_of(floor("ward"))
    field = MapDistance(solids, 0.3)
    lines = shapely.union_all([shapely.Polygon(one.corners).exterior for one in solids if one.bottom <= 0.3 < one.top])
    shapely.prepare(lines)
    draw = random.Random(1)
    points = np.array([(draw.uniform(-5.0, 36.0), draw.uniform(-7.0, 7.0)) for _ in range(2000)])
    expected = np.minimum(shapely.distance(lines, shapely.points(points)), FARTHEST)
    assert np.abs(field.at(points[:, 0], points[:, 1]) - expected).max() <= CELL * 0.5**0.5 + 1e-6
    assert np.abs(field.between(points[:, 0], points[:, 1]) - expected).max() <= CELL * 0.5**0.5 + 1e-6


def test_outside_the_map_is_far() -> None:
    field = MapDistance(solids_of(floor("ward")), 0.3)
    assert field.at(np.array([500.0]), np.array([0.0])) == pytest.approx([FARTHEST])


def test_table_top_is_not_at_the_height_of_legs() -> None:
    solids = solids_of(floor("ward"))
    middle = np.array([2.4]), np.array([-4.2])
    assert MapDistance(solids, 0.3).at(*middle)[0] > MapDistance(solids, 0.7).at(*middle)[0]
