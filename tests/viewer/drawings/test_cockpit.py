from __future__ import annotations

import math

import numpy as np
import pytest
import viser

from intellwheels_viewer.drawings.cockpit import LEAN, Cockpit, lean
from tests.viewer.drawings.cast import entity, node, robot


def tip(left: float, right: float) -> list[float]:
    """Return where the top of a joystick 1 m long is."""
    w, x, y, z = lean(left, right)
    up = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    return [float(each) for each in up]


def test_a_joystick_leans_where_the_chair_is_told_to_go() -> None:
    assert tip(0.0, 0.0) == pytest.approx([0.0, 0.0, 1.0])
    assert tip(1.0, 1.0) == pytest.approx([math.sin(LEAN), 0.0, math.cos(LEAN)])
    assert tip(-1.0, -1.0)[0] == pytest.approx(-math.sin(LEAN))
    assert tip(-1.0, 1.0) == pytest.approx([0.0, math.sin(LEAN), math.cos(LEAN)])
    assert tip(5.0, 5.0) == pytest.approx(tip(1.0, 1.0))


def test_the_hand_goes_with_its_chair_and_only_a_chair_has_one(scene: viser.SceneApi) -> None:
    cockpit = Cockpit(scene)
    cockpit.show(robot("table"), entity("a"))
    assert node(scene, "/cockpit") is None
    cockpit.show(robot("rear-wheel"), entity("a", 3.0, 4.0, left_output=0.5, right_output=0.5))
    chair, grip = node(scene, "/cockpit"), node(scene, "/cockpit/grip")
    assert tuple(chair.position) == pytest.approx((3.0, 4.0, 0.0))
    assert grip.position[1] == pytest.approx(-0.2)
    assert tuple(grip.wxyz) == pytest.approx(lean(0.5, 0.5))
    cockpit.show(None, None)
    assert not chair.visible


def test_hands_and_shoes_are_made_once_for_a_size_of_chair(scene: viser.SceneApi) -> None:
    cockpit = Cockpit(scene)
    cockpit.show(robot("rear-wheel"), entity("a"))
    rest, grip = node(scene, "/cockpit/rest"), node(scene, "/cockpit/grip")
    cockpit.show(None, None)
    cockpit.show(robot("rear-wheel"), entity("b", 1.0))
    assert node(scene, "/cockpit/rest") is rest
    cockpit.show(robot("mid-wheel"), entity("c"))
    assert node(scene, "/cockpit/rest") is not rest
    assert node(scene, "/cockpit/grip") is grip
    assert node(scene, "/cockpit/rest").visible
