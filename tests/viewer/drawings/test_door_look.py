from __future__ import annotations

import numpy as np
import pytest

from intellwheels_viewer.drawings.door_look import door
from tests.viewer.drawings.cast import robot


def test_a_leaf_is_cut_as_walls_are() -> None:
    assert float(door(robot("door"), cut=1.1).paint.vertices[:, 2].max()) == pytest.approx(1.1)
    assert float(door(robot("door")).paint.vertices[:, 2].max()) == pytest.approx(2.0)


def test_the_handles_are_at_the_end_far_from_the_hinge_on_both_sides() -> None:
    handles = door(robot("door")).light.vertices
    assert float(handles[:, 0].max()) < -0.7
    assert np.sign(handles[:, 1]).min() < 0 < np.sign(handles[:, 1]).max()


def test_a_low_leaf_has_no_handle() -> None:
    assert len(door(robot("door", top=0.3)).light.faces) == 0
