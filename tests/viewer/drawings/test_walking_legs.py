from __future__ import annotations

import math

import numpy as np
import pytest
import viser

from intellwheels_viewer.drawings.person_look import person
from intellwheels_viewer.drawings.walking_legs import STRIDE, SWING, WalkingLegs, poses, swing
from tests.viewer.drawings.cast import entity, node, robot

LEG = person(robot("person")).leg


def test_a_leg_swings_once_in_a_stride_and_hangs_when_nobody_walks() -> None:
    assert swing(0.25 * STRIDE, 1.4) == pytest.approx(SWING)
    assert swing(0.75 * STRIDE, 1.4) == pytest.approx(-SWING)
    assert swing(0.25 * STRIDE, 0.0) == 0.0
    assert abs(swing(0.25 * STRIDE, 0.6)) < SWING


def foot(wxyz: np.ndarray[tuple[int, ...], np.dtype[np.float32]]) -> list[float]:
    """Return where a foot is, one metre below the hip."""
    w, x, y, z = (float(value) for value in wxyz)
    return [-(2 * (x * z + w * y)), -(2 * (y * z - w * x)), -(1 - 2 * (x * x + y * y))]


def test_the_left_foot_is_ahead_while_the_right_one_is_behind() -> None:
    assert LEG is not None
    walker = entity("p", 1.0, 2.0, math.pi / 2, speed=1.4)
    places, turns = poses(LEG, [walker], [0.25 * STRIDE])
    left, right = foot(turns[0]), foot(turns[1])
    assert left == pytest.approx([0.0, math.sin(SWING), -math.cos(SWING)], abs=1e-6)
    assert right == pytest.approx([0.0, -math.sin(SWING), -math.cos(SWING)], abs=1e-6)
    assert places[0][0] < 1.0 < places[1][0], "who walks north has the left leg in the west"


def test_legs_follow_the_path_and_in_a_playback_what_was_seen_of_it(scene: viser.SceneApi) -> None:
    assert LEG is not None
    legs = WalkingLegs(scene, "/legs", LEG, lambda _: None)
    legs.show([entity("p", speed=1.4, travelled=0.25 * STRIDE)])
    handle = node(scene, "/legs")
    assert handle.batched_wxyzs[0][2] == pytest.approx(-math.sin(SWING / 2), abs=1e-6)
    legs.show([entity("p", speed=1.4)])
    legs.show([entity("p", 0.1 * STRIDE, speed=1.4)])
    assert handle.batched_positions.shape == (2, 3)
    assert abs(float(handle.batched_wxyzs[0][2])) > 0.01
    legs.show([])
    assert not handle.visible
