"""Projected motions, and whether they keep their clearances."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from intellwheels_agents.navigation.motion_projection import CLEARANCE_SHARE, MotionProjection
from intellwheels_agents.range_scan import Outline, outline
from intellwheels_agents.wheel_motors import Motors, Wheels
from intellwheels_maps import robot

FOOTPRINT = MotionProjection(Outline(front=0.8, back=0.3, side=0.3), 0.5, Motors(0.0, 0.0, math.inf, 0.05))
STILL = Wheels(0.0, 0.0)


def free(point: tuple[float, float], wanted: Wheels, margin: float = 0.05, swing: float = 0.0) -> bool:
    way = FOOTPRINT.poses(STILL, wanted, 1.0)
    return FOOTPRINT.is_free(way, FOOTPRINT.watched(np.array([point]), margin, swing, way[-1][3]), swing)


@pytest.mark.parametrize(
    ("point", "room"),
    [((1.0, 0.0), 0.2), ((0.0, 0.5), 0.2), ((-0.4, 0.0), 0.1), ((1.1, 0.7), 0.5), ((0.5, 0.0), -0.3)],
)
def test_clearance_to_a_point(point: tuple[float, float], room: float) -> None:
    x, y = np.array([point]).T
    assert FOOTPRINT.clearance(x, y, 0.0).tolist() == [pytest.approx(room)]


def test_poses_follow_the_motors_until_the_body_stands_at_any_period() -> None:
    document = msgspec.structs.replace(robot("front-wheel"), acceleration_limit=0.8)
    ends = []
    for period in (0.01, 0.05, 0.2):
        print_ = MotionProjection(outline(document), document.track, Motors.of(document, period))
        ends.append(print_.poses(STILL, Wheels(0.36, 0.63), 1.0)[-1][:3])
    assert ends[0][0] > 0.4
    assert ends[1] == pytest.approx(ends[0], abs=0.01)
    # Where the limit acts in a part of a cycle only, the cycle takes it as a whole.
    assert ends[2] == pytest.approx(ends[0], abs=0.05)


def test_motion_ends_with_the_braking_distance() -> None:
    slow = MotionProjection(FOOTPRINT.outline, 0.5, Motors(0.0, 0.0, 0.5, 0.05))
    way = slow.poses(Wheels(1.0, 1.0), Wheels(1.0, 1.0), 0.05)
    assert way[-1][0] == pytest.approx(0.05 + 1.0, abs=0.01)


@pytest.mark.parametrize(("gap", "is_it"), [(0.56, True), (0.54, False)])
def test_motion_ends_a_margin_before_an_obstacle(gap: float, is_it: bool) -> None:
    assert free((0.8 + gap, 0.1), Wheels(0.5, 0.5)) is is_it


def test_thin_obstacle_is_not_missed_between_two_checks() -> None:
    # A corner at 0.85 m swings past it in a seventh of a second.
    angle = math.atan2(0.3, 0.8) + 0.7
    assert not free((0.82 * math.cos(angle), 0.82 * math.sin(angle)), Wheels(-1.5, 1.5), margin=0.0)


def test_obstacle_too_near_never_blocks_the_way_back() -> None:
    touching = (0.801, 0.0)
    assert not free(touching, Wheels(0.1, 0.1))
    assert free(touching, Wheels(-0.5, -0.5))


def test_driving_along_a_near_wall_is_free_but_not_into_it() -> None:
    beside = (0.5, 0.3 + 0.02)
    assert free(beside, Wheels(0.5, 0.5))
    assert not free(beside, Wheels(0.45, 0.55))
    assert 0.0 < CLEARANCE_SHARE < 1.0


def test_last_centimetre_is_not_used_up() -> None:
    # Towards a wall at its side, at 2 mm a second: free as long as more than a centimetre is left.
    for gap, is_it in ((0.03, True), (0.009, False)):
        assert free((0.5, 0.3 + gap), Wheels(0.5, 0.502)) is is_it
        assert free((0.5, 0.3 + gap), Wheels(0.5, 0.5))
        assert free((0.5, 0.3 + gap), Wheels(0.502, 0.5))


def test_swing_room_is_kept_ahead_and_the_body_itself_still_counts() -> None:
    assert free((1.4, 0.0), Wheels(0.5, 0.5))
    assert not free((1.4, 0.0), Wheels(0.5, 0.5), swing=0.1)
    # Already inside the lengthened footprint, at its side: only the clearance of the body itself shows the collision.
    assert not free((0.85, 0.29), Wheels(0.5, 0.5), swing=0.1)


def test_motion_without_obstacles_is_free() -> None:
    way = FOOTPRINT.poses(STILL, Wheels(1.0, 1.0), 1.0)
    nothing = FOOTPRINT.watched(np.empty((0, 2)), 0.05, 0.0, way[-1][3])
    assert FOOTPRINT.is_free(way, nothing, 0.0)


def test_point_among_many_that_comes_too_near_late_in_the_motion_is_found() -> None:
    way = FOOTPRINT.poses(STILL, Wheels(0.5, 0.5), 1.0)
    wall = np.column_stack([np.linspace(-1.0, 1.2, 200), np.full(200, 0.4)])
    assert FOOTPRINT.is_free(way, FOOTPRINT.watched(wall, 0.05, 0.0, way[-1][3]), 0.0)
    for gap, is_it in ((0.56, True), (0.54, False)):
        points = np.concatenate([wall, [(0.8 + gap, 0.0)]])
        assert FOOTPRINT.is_free(way, FOOTPRINT.watched(points, 0.05, 0.0, way[-1][3]), 0.0) is is_it
