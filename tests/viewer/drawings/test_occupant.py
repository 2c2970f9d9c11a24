from __future__ import annotations

import numpy as np
import pytest

from intellwheels_viewer.drawings.chair_frame import arm_height, frame_of, stick
from intellwheels_viewer.drawings.occupant import HAIR, SHOES, SKIN, eyes, occupant, palms, wrists
from tests.viewer.drawings.cast import robot

CHAIRS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels")


@pytest.mark.parametrize("name", CHAIRS)
@pytest.mark.parametrize("crowd", [False, True])
def test_a_person_sits_within_the_box_of_the_chair(name: str, crowd: bool) -> None:
    frame = frame_of(robot(name))
    shirt, rest = occupant(frame, crowd=crowd)
    points = np.concatenate([shirt.vertices, *(each.vertices for each in rest.values())])
    hull = frame.hull
    assert (points.min(axis=0) >= (hull.rear - 0.002, hull.right - 0.002, 0.0)).all()
    assert (points.max(axis=0) <= (hull.front + 0.002, hull.left + 0.002, hull.top + 0.002)).all()
    assert float(rest[HAIR].vertices[:, 2].max()) == pytest.approx(hull.top, abs=0.03)
    if not crowd:
        assert float(rest[SHOES].vertices[:, 0].max()) == pytest.approx(hull.front, abs=0.02)


def test_the_right_hand_is_at_the_joystick_and_the_eyes_in_the_head() -> None:
    frame = frame_of(robot("rear-wheel"))
    skin = occupant(frame)[1][SKIN].vertices
    left, right = palms(frame)
    for palm, wrist in zip((left, right), wrists(frame), strict=True):
        assert float(np.linalg.norm(skin - np.array(palm), axis=1).min()) < 0.06
        assert wrist[0] < palm[0]
        assert palm[2] > arm_height(frame)
    assert right[1] < 0.0 < left[1]
    assert np.linalg.norm(np.subtract(right[:2], stick(frame))) < 0.1
    assert 1.1 < eyes(frame)[2] < 1.3


def test_one_of_a_crowd_has_few_triangles() -> None:
    shirt, rest = occupant(frame_of(robot("mid-wheel")), crowd=True)
    assert len(shirt.faces) + sum(len(each.faces) for each in rest.values()) <= 200
