"""Outlines on the floor."""

from __future__ import annotations

import math

import pytest

from intellwheels_maps import library
from intellwheels_viewer.panels.plan_footprints import footprint, outline, placed


def test_one_part_form_is_measured_from_its_centre_of_movement() -> None:
    door = library.robot("door")
    shape = footprint(door)
    assert door.center is not None
    assert door.length is not None
    assert (shape.front, shape.rear) == pytest.approx((door.length * (1 - door.center), -door.length * door.center))


def test_several_parts_have_one_rectangle() -> None:
    assert footprint(library.robot("table")) == pytest.approx((-0.8, -0.4, 0.8, 0.4))


def test_points_turn_anticlockwise_about_the_centre_of_movement() -> None:
    assert placed(((1.0, 0.0),), 2.0, 3.0, math.pi / 2) == [pytest.approx((2.0, 4.0))]


def test_outline_goes_anticlockwise() -> None:
    ring = outline(footprint(library.robot("table")), 1.0, 1.0, 0.7)
    area = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)) / 2
    assert area == pytest.approx(1.6 * 0.8)
