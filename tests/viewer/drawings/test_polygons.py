from __future__ import annotations

import math

import pytest

from intellwheels_viewer.drawings import polygons

COMB = [(0.0, 0.0), (5.0, 0.0), (5.0, 3.0), (4.0, 3.0), (4.0, 1.0), (3.0, 1.0), (3.0, 3.0), (0.0, 3.0)]


def test_area_has_the_sense_of_the_corners() -> None:
    assert polygons.area(COMB) == pytest.approx(13.0)
    assert polygons.area(COMB[::-1]) == pytest.approx(-13.0)
    assert polygons.anticlockwise(COMB[::-1]) == COMB


def test_triangles_cover_a_hollow_polygon_once() -> None:
    cut = polygons.triangles(COMB)
    assert len(cut) == len(COMB) - 2
    areas = [polygons.area([COMB[index] for index in corners]) for corners in cut]
    assert min(areas) >= 0.0
    assert sum(areas) == pytest.approx(13.0)


def test_a_polygon_that_crosses_itself_still_ends() -> None:
    assert len(polygons.triangles([(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])) <= 2


def test_a_polygon_of_ten_thousand_corners_is_cut_whole() -> None:
    """With ear clipping of our own it took minutes, and the page stood still."""
    count = 10_000
    angles = [2.0 * math.pi * k / count for k in range(count)]
    star = [((5 + k % 2) * math.cos(angle), (5 + k % 2) * math.sin(angle)) for k, angle in enumerate(angles)]
    areas = [polygons.area([star[index] for index in corners]) for corners in polygons.triangles(star)]
    assert min(areas) >= 0.0
    assert sum(areas) == pytest.approx(polygons.area(star))


def test_bounds_are_least_and_largest() -> None:
    assert polygons.bounds(COMB) == (0.0, 5.0, 0.0, 3.0)
