from __future__ import annotations

import numpy as np
import pytest

from intellwheels_viewer.drawings.chair_frame import frame_of
from intellwheels_viewer.drawings.chair_look import chair
from intellwheels_viewer.drawings.occupant import SKIN
from intellwheels_viewer.drawings.real_badge import LETTERS, PLATE
from intellwheels_viewer.drawings.solids import Solid
from tests.viewer.drawings.cast import robot

CHAIRS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels")


@pytest.mark.parametrize("name", CHAIRS)
def test_the_drive_wheels_stand_where_and_as_large_as_the_robot_says(name: str) -> None:
    document = robot(name)
    frame = frame_of(document)
    assert frame.wheel == document.wheel_diameter / 2
    assert frame.side == pytest.approx(document.track / 2)
    tyres = chair(document).dark.vertices
    at_wheel = tyres[(abs(tyres[:, 1] - frame.side) < frame.tyre / 2) & (np.abs(tyres[:, 0]) < frame.wheel + 1e-4)]
    assert float(at_wheel[:, 2].min()) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("name", CHAIRS)
def test_the_seat_is_that_of_the_robots_parts(name: str) -> None:
    document = robot(name)
    seat, frame = document.part[1], frame_of(document)
    assert frame.seat == seat.bottom
    assert (frame.rear, frame.front) == (seat.x - seat.length / 2, seat.x + seat.length / 2)


def shadow(solid: Solid) -> float:
    """Return the area of the triangles that look up."""
    a, b, c = (solid.vertices[solid.faces[:, k]] for k in range(3))
    up = np.cross(b - a, c - a)[:, 2] / 2
    return float(up[up > 0].sum())


@pytest.mark.parametrize("name", CHAIRS)
def test_paint_is_seen_from_above(name: str) -> None:
    model = chair(robot(name))
    highest = model.paint.vertices[:, 2].max()
    assert highest == pytest.approx(robot(name).part[1].top, abs=1e-6), "the headrest is painted"
    assert shadow(model.paint) > 0.3
    assert len(model.light.faces) > 200, "spokes and hand rims"


@pytest.mark.parametrize("name", CHAIRS)
def test_a_chair_has_at_most_four_thousand_triangles_and_one_of_a_crowd_six_hundred(name: str) -> None:
    assert 60 < chair(robot(name), crowd=True).triangles <= 600
    assert chair(robot(name)).triangles <= 4000


def test_a_chair_of_one_box_has_a_seat_too() -> None:
    document = robot("rear-wheel", part=(), length=1.1, width=0.6, center=0.3, top=1.2)
    frame = frame_of(document)
    assert frame.hull.rear == pytest.approx(-0.33)
    assert 0.3 < frame.seat < 0.6
    assert frame.front < frame.hull.front


@pytest.mark.parametrize("name", ["rear-wheel", "mid-wheel", "front-wheel", "intellwheels"])
def test_an_occupied_chair_has_a_person_and_few_more_triangles(name: str) -> None:
    empty, occupied = chair(robot(name)), chair(robot(name), occupied=True)
    assert SKIN in occupied.trim
    assert SKIN not in empty.trim
    assert empty.triangles < occupied.triangles <= 5000
    assert chair(robot(name), crowd=True, occupied=True).triangles <= 600


def test_a_real_chair_has_its_plates_and_a_white_band() -> None:
    real, virtual = chair(robot("intellwheels", type="real")), chair(robot("intellwheels"))
    assert {PLATE, LETTERS} <= real.trim.keys()
    acted = chair(robot("intellwheels", type="real", hardware="simulated"))
    assert len(acted.trim[LETTERS].faces) > len(real.trim[LETTERS].faces), "STAND-IN is longer than REAL"
    assert not {PLATE, LETTERS} & virtual.trim.keys()
