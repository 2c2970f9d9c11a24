"""Bumpers: pressed while the body touches something."""

from __future__ import annotations

from intellwheels_schemas.messages import Bumper
from intellwheels_server.world import State, measures
from tests.server.worlds import box_wall, cart, run, world


def _pressed(state: State, agent: str = "a") -> bool:
    sensors = measures(state, agent).sensors
    assert sensors is not None
    return sensors.bumper[0].value


def test_bumper_is_pressed_at_a_wall_and_released_away_from_it() -> None:
    state = world({"a": cart(bumper=(Bumper(id="b"),))}, [box_wall(1.0, -1.0, 2.0, 1.0)])
    assert not _pressed(state)
    state, _ = run(state, 12, {"a": (1.0, 1.0)})
    assert _pressed(state)
    state, _ = run(state, 5, {"a": (-1.0, -1.0)})
    assert not _pressed(state)


def test_who_is_run_into_feels_it_too() -> None:
    robots = {"a": cart(bumper=(Bumper(id="b"),)), "b": cart(1.2, bumper=(Bumper(id="b"),))}
    state, _ = run(world(robots), 8, {"a": (1.0, 1.0)})
    assert _pressed(state, "a")
    assert _pressed(state, "b")
