"""The forces on a pedestrian who walks east."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.range_ring import NearObject
from intellwheels_agents.social_force import POTENTIAL, REACH, attraction, drive, elliptic, repulsion

EAST = (1.34, 0.0)


def near(metres: float, bearing_deg: float, velocity: tuple[float, float] = (0.0, 0.0)) -> NearObject:
    bearing = math.radians(bearing_deg)
    return NearObject(metres * math.cos(bearing), metres * math.sin(bearing), metres, bearing, *velocity)


def push(*objects: NearObject) -> tuple[float, float]:
    return repulsion(objects, EAST, EAST, EAST, 0.0)


def test_drive_reaches_the_wanted_velocity_in_the_relaxation_time() -> None:
    assert drive((1.0, 0.0), (0.0, 0.5)) == (2.0, -1.0)


def test_force_between_standing_people_depends_on_distance() -> None:
    force, x, y = elliptic(near(0.8, 0.0), (0.0, 0.0))
    assert force == pytest.approx(POTENTIAL / REACH * math.exp(-1.0 / REACH))
    assert (x, y) == pytest.approx((-1.0, 0.0))


def test_approaching_object_acts_from_afar_and_one_moving_along_hardly() -> None:
    coming, along = push(near(3.0, 10.0, (-1.34, 0.0))), push(near(3.0, 10.0, EAST))
    assert math.hypot(*coming) > 10.0 * math.hypot(*along)
    assert coming[0] < 0.0


def test_object_ahead_is_passed_on_the_right_and_one_aside_on_its_other_side() -> None:
    assert push(near(2.0, 0.0))[1] < 0.0
    assert push(near(2.0, 10.0))[1] < 0.0
    assert push(near(2.0, -10.0))[1] > 0.0


def test_object_behind_acts_less() -> None:
    ahead, behind = (repulsion([near(0.5, bearing)], EAST, (0.0, 0.0), (0.0, 0.0), 0.0) for bearing in (0.0, 180.0))
    assert behind[0] == pytest.approx(-0.1 * ahead[0])


def test_group_attracts_a_member_far_from_its_centre() -> None:
    assert attraction((0.0, 0.0), [(3.0, 0.0)]) == pytest.approx((1.0, 0.0))
    assert attraction((0.0, 0.0), [(0.9, 0.0)]) == (0.0, 0.0)
    assert attraction((0.0, 0.0), []) == (0.0, 0.0)
