"""A car keeps to its lane and gives way."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from intellwheels_agents.options import OptionError
from intellwheels_schemas.messages import Position
from tests.agents.arena import Arena

FRONT = 2.2
"""Metres from the car's centre of movement to its front."""


def street() -> Arena:
    arena = Arena("crossing")
    arena.join("car", "car", "car", "west", {"to": "east-end"})
    return arena


def test_free_road_is_driven_at_the_wanted_speed_to_its_end() -> None:
    arena = street()
    took = arena.run(60.0, lambda arena: arena.paths["car"][-1][0] > 23.0)
    assert took < 18.0
    assert max(abs(y + 1.5) for _, y, _ in arena.paths["car"]) < 0.1
    xs = [x for x, _, _ in arena.paths["car"]]
    assert max(b - a for a, b in pairwise(xs)) / 0.05 == pytest.approx(5.0, rel=0.07)
    arena.run(5.0)
    assert arena.speed("car") == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("y", [-2.8, -1.5, -0.2])
def test_car_stops_before_an_obstacle_in_its_lane(y: float) -> None:
    arena = street()
    arena.join("crate", "drive", "crate", None, {}, Position(x=0.0, y=y, heading=0.0))
    arena.run(20.0)
    gap = -0.3 - (arena.paths["car"][-1][0] + FRONT)
    assert 0.5 < gap < 4.0
    assert arena.speed("car") < 0.05
    assert arena.contacts() == []


def test_obstacle_on_the_pavement_does_not_stop_the_car() -> None:
    arena = street()
    arena.join("crate", "drive", "crate", None, {}, Position(x=0.0, y=-5.2, heading=0.0))
    arena.run(18.0)
    assert arena.paths["car"][-1][0] > 20.0


@pytest.mark.parametrize("start", [3.0, 4.0, 5.0, 5.6])
def test_car_lets_a_pedestrian_cross_and_drives_on(start: float) -> None:
    arena = street()
    at = Position(x=0.0, y=start, heading=-math.pi / 2.0)
    arena.join("one", "person", "person", None, {"points": "0 -5", "speed": "0.8"}, at)
    arena.run(30.0, lambda arena: arena.paths["car"][-1][0] > 23.0)
    assert arena.contacts() == []
    assert arena.paths["car"][-1][0] > 23.0
    assert math.dist(arena.paths["one"][-1][:2], (0.0, -5.0)) < 0.6


def test_robot_without_encoders_cannot_drive() -> None:
    with pytest.raises(OptionError, match="expected a robot with encoders"):
        Arena("crossing").join("blind", "car", "crate", "west", {"to": "east-end"})
