from __future__ import annotations

import itertools

import numpy as np
import pytest
import viser

from intellwheels_viewer import palette
from intellwheels_viewer.drawings.trails import STEP, Trail, Trails, segments
from intellwheels_viewer.palette import Colours
from intellwheels_viewer.snapshot import TRAIL, Sample
from tests.viewer.drawings.cast import node


def straight(count: int, speed: float = 0.5) -> list[Sample]:
    return [Sample(0.05 * tick, speed * 0.05 * tick, 0.0, 0.0, speed) for tick in range(count)]


def trail(history: list[Sample], now: float) -> list[list[float]]:
    return [[float(value) for value in corner] for corner in Trail().corners(history, now)]


def test_a_trail_ends_at_the_newest_sample_and_goes_back_twenty_seconds() -> None:
    corners = trail(straight(801), 40.0)
    assert corners[-1][0] == pytest.approx(20.0)
    assert corners[0][2] == pytest.approx(40.0 - TRAIL, abs=0.2)


def test_corners_are_a_step_apart_and_a_body_at_rest_has_few() -> None:
    corners = trail(straight(201), 10.0)
    gaps = [b[0] - a[0] for a, b in itertools.pairwise(corners)]
    assert min(gaps) >= STEP
    assert len(trail(straight(401, 0.0), 20.0)) <= 2


def test_a_trail_begins_anew_where_the_body_was_put() -> None:
    moved = [Sample(1.0, 0.0, 0.0, 0.0, 0.0), Sample(1.05, 5.0, 0.0, 0.0, 0.0), Sample(1.1, 5.1, 0.0, 0.0, 0.0)]
    assert [corner[0] for corner in trail(moved, 1.1)] == pytest.approx([5.0, 5.1])


def test_a_trail_grows_by_what_is_new_as_if_it_were_made_at_once() -> None:
    history, grown = straight(801), Trail()
    for end in (1, 2, 40, 41, 300, 600, 801):
        now = history[end - 1].time
        found = grown.corners(history[max(0, end - 610) : end], now)
        whole = np.array(trail(history[:end], now))
        assert found[-1] == pytest.approx(whole[-1])
        assert found == pytest.approx(whole, abs=1e-4)


def test_a_history_of_another_run_is_another_trail() -> None:
    one = Trail()
    one.corners(straight(200), 9.95)
    other = [Sample(0.05 * tick, 0.0, 0.5 * 0.05 * tick, 0.0, 0.5) for tick in range(40)]
    assert float(abs(one.corners(other, 1.95)[:, 0]).max()) == 0.0
    assert len(one.corners([], 1.95)) == 0


def test_no_stretch_joins_two_agents() -> None:
    far = [Sample(each.time, each.x + 50.0, 0.0, 0.0, 0.5) for each in straight(100)]
    corners = [Trail().corners(history, 4.95) for history in (straight(100), [], far)]
    points, _ = segments(corners, 4.95, [(0, 0, 0)] * 3)
    assert len(points) == sum(max(len(each) - 1, 0) for each in corners)
    assert float(abs(points[:, 0, 0] - points[:, 1, 0]).max()) < 1.0


def test_it_fades_towards_its_old_end() -> None:
    points, tints = segments([Trail().corners(straight(401), 20.0)], 20.0, [Colours().rgb("a")])
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
