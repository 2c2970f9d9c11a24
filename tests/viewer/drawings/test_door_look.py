from __future__ import annotations

import numpy as np
import pytest

from intellwheels_schemas.agent_colours import FIXTURES
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer.drawings.body_look import extent
from intellwheels_viewer.drawings.building_colours import DAY
from intellwheels_viewer.drawings.door_look import EDGE, door
from tests.viewer.drawings.cast import robot


def test_a_leaf_is_cut_as_walls_are() -> None:
    assert float(door(robot("door"), cut=1.1).paint.vertices[:, 2].max()) == pytest.approx(1.1)
    assert float(door(robot("door")).paint.vertices[:, 2].max()) == pytest.approx(2.0)


def test_the_handles_are_at_the_end_far_from_the_hinge_on_both_sides() -> None:
    light = door(robot("door")).light.vertices
    handles = light[abs(light[:, 1]) > 0.075]
    assert float(handles[:, 0].max()) < -0.65
    assert np.sign(handles[:, 1]).min() < 0 < np.sign(handles[:, 1]).max()


def test_the_hinges_are_at_the_end_at_which_it_turns() -> None:
    light = door(robot("door"), cut=1.1).light.vertices
    ends = light[light[:, 0] > -0.025]
    assert len(ends)
    assert {bool(z > 0.5) for z in ends[:, 2]} == {True, False}


def test_a_leaf_is_of_wood_with_panels_and_a_kick_plate_on_both_faces_and_no_larger_than_it_is() -> None:
    look, leaf = door(robot("door")), extent(parts_of(robot("door")))
    for solid in (look.dark, look.light):
        low = solid.vertices[solid.vertices[:, 2] < 0.5]
        assert low[:, 1].min() < leaf.right
        assert low[:, 1].max() > leaf.left
    assert abs(look.dark.vertices[:, 1]).max() < leaf.left + 0.01
    assert look.dark_rgb == EDGE
    # The colours of wood: red over green over blue, in the leaf, its edges and its frame.
    for red, green, blue in (FIXTURES["door"], EDGE, DAY.frame):
        assert red > green > blue


def test_a_low_leaf_has_no_handle() -> None:
    assert len(door(robot("door", top=0.3)).light.faces) == 0
