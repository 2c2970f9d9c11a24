from __future__ import annotations

import numpy as np
import pytest

from intellwheels_schemas.messages import Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer.drawings.body_look import BodyLook, extent
from intellwheels_viewer.drawings.looks import model_of, shape_of
from tests.every_case import every_case
from tests.viewer.drawings.cast import robot

ROBOTS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels", "person", "table", "door", "crate")


def box(model: BodyLook) -> list[float]:
    vertices = np.concatenate([model.paint.vertices, model.dark.vertices, model.light.vertices])
    return [float(each) for each in (*vertices.min(axis=0), *vertices.max(axis=0))]


@every_case("name", ROBOTS)
@every_case("crowd", [False, True])
def test_a_body_fills_the_box_around_its_parts_and_does_not_leave_it(name: str, crowd: bool) -> None:
    document = robot(name)
    hull = extent(parts_of(document))
    x0, y0, z0, x1, y1, z1 = box(model_of(document, crowd=crowd))
    # A door's handles stick out.
    aside = 0.06 if name == "door" else 0.002
    assert hull.rear - 0.002 <= x0
    assert x1 <= hull.front + 0.002
    assert hull.right - aside <= y0
    assert y1 <= hull.left + aside
    assert z0 >= -1e-6
    assert z1 == pytest.approx(hull.top, abs=0.002)
    assert x1 - x0 >= 0.7 * hull.length
    assert y1 - y0 >= 0.9 * hull.width


def test_a_larger_robot_of_a_kind_is_drawn_larger() -> None:
    small, large = Robot(kind="car", length=1.0, width=0.5, top=0.8), Robot(kind="car", length=4.0, width=1.8, top=1.5)
    assert box(model_of(large))[3] == pytest.approx(2.0, abs=0.002)
    assert box(model_of(small))[5] == pytest.approx(0.8)


def test_a_mind_without_a_body_has_no_look() -> None:
    assert model_of(Robot(kind="wheelchair")).triangles == 0


def test_bodies_that_differ_in_noise_alone_look_the_same() -> None:
    assert shape_of(robot("rear-wheel")) == shape_of(robot("rear-wheel", motor_noise=0.1))
    assert shape_of(robot("rear-wheel")) != shape_of(robot("mid-wheel"))
    assert shape_of(robot("rear-wheel")) != shape_of(robot("rear-wheel", wheel_diameter=0.4))
    assert shape_of(robot("rear-wheel")) != shape_of(robot("rear-wheel"), crowd=True)
