"""The forces on somebody who walks to the east."""

from __future__ import annotations

import math

import pytest

from intellwheels_agents.range_ring import Thing
from intellwheels_agents.social_force import POTENTIAL, REACH, attraction, drive, elliptic, repulsion

EAST = (1.34, 0.0)


def thing(metres: float, bearing_deg: float, velocity: tuple[float, float] = (0.0, 0.0)) -> Thing:
    bearing = math.radians(bearing_deg)
    return Thing(metres * math.cos(bearing), metres * math.sin(bearing), metres, bearing, *velocity)


def push(*things: Thing) -> tuple[float, float]:
    return repulsion(things, EAST, EAST, EAST, 0.0)


def test_drive_takes_a_velocity_to_the_wanted_one_in_the_relaxation_time() -> None:
    assert drive((1.0, 0.0), (0.0, 0.5)) == (2.0, -1.0)


def test_between_two_who_stand_the_force_is_that_of_the_distance() -> None:
    force, x, y = elliptic(thing(0.8, 0.0), (0.0, 0.0))
    assert force == pytest.approx(POTENTIAL / REACH * math.exp(-1.0 / REACH))
    assert (x, y) == pytest.approx((-1.0, 0.0))


def test_who_comes_nearer_is_felt_from_afar_and_who_walks_along_hardly() -> None:
    coming, along = push(thing(3.0, 10.0, (-1.34, 0.0))), push(thing(3.0, 10.0, EAST))
    assert math.hypot(*coming) > 10.0 * math.hypot(*along)
    assert coming[0] < 0.0


def test_what_is_straight_ahead_is_passed_on_the_right_and_what_is_aside_on_its_other_side() -> None:
    assert push(thing(2.0, 0.0))[1] < 0.0
    assert push(thing(2.0, 10.0))[1] < 0.0
    assert push(thing(2.0, -10.0))[1] > 0.0


def test_what_is_behind_is_felt_less() -> None:
    ahead, behind = (repulsion([thing(0.5, bearing)], EAST, (0.0, 0.0), (0.0, 0.0), 0.0) for bearing in (0.0, 180.0))
    assert behind[0] == pytest.approx(-0.1 * ahead[0])


def test_company_draws_who_is_far_from_its_middle() -> None:
    assert attraction((0.0, 0.0), [(3.0, 0.0)]) == pytest.approx((1.0, 0.0))
    assert attraction((0.0, 0.0), [(0.9, 0.0)]) == (0.0, 0.0)
    assert attraction((0.0, 0.0), []) == (0.0, 0.0)
