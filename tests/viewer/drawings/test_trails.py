from __future__ import annotations

import itertools

import pytest
import viser

from intellwheels_viewer import palette
from intellwheels_viewer.drawings.trails import LENGTH, STEP, Trails, segments, trail
from intellwheels_viewer.palette import Colours
from intellwheels_viewer.seen import Sample
from tests.viewer.drawings.cast import node


def straight(count: int, speed: float = 0.5) -> list[Sample]:
    return [Sample(0.05 * tick, speed * 0.05 * tick, 0.0, 0.0, speed) for tick in range(count)]


def test_a_trail_ends_at_the_newest_sample_and_goes_back_twenty_seconds() -> None:
    corners = trail(straight(801), 40.0)
    assert corners[-1][0] == pytest.approx(20.0)
    assert corners[0][2] == pytest.approx(LENGTH)


def test_corners_are_a_step_apart_and_a_body_at_rest_has_few() -> None:
    corners = trail(straight(201), 10.0)
    gaps = [b[0] - a[0] for a, b in itertools.pairwise(corners)]
    assert min(gaps) >= STEP
    assert len(trail(straight(401, 0.0), 20.0)) <= 2


def test_a_trail_begins_anew_where_the_body_was_put() -> None:
    moved = [Sample(1.0, 0.0, 0.0, 0.0, 0.0), Sample(1.05, 5.0, 0.0, 0.0, 0.0), Sample(1.1, 5.1, 0.0, 0.0, 0.0)]
    assert [corner[0] for corner in trail(moved, 1.1)] == [5.0, 5.1]


def test_it_fades_towards_its_old_end() -> None:
    points, tints = segments({"a": straight(401)}, 20.0, Colours())
    assert points.shape == tints.shape
    old, new = tints[0, 0], tints[-1, 1]
    assert abs(old - palette.FLOOR).sum() < abs(new - palette.FLOOR).sum()


def test_the_node_is_kept_and_hidden_when_nobody_has_gone(scene: viser.SceneApi) -> None:
    trails = Trails(scene)
    trails.show({"a": straight(100)}, 5.0, Colours())
    handle = node(scene, "/trails/lines")
    trails.show({}, 5.0, Colours())
    assert not handle.visible
    trails.show({"a": straight(200)}, 10.0, Colours())
    assert node(scene, "/trails/lines") is handle
    assert handle.visible
