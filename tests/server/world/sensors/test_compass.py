"""Compasses: the heading in (-pi, pi], with keyed noise and steps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_schemas.messages import Compass
from intellwheels_server.world import State, measures
from tests.server.worlds import ROUNDED, cart, run, world


def _heading(state: State, agent: str = "a") -> float:
    sensors = measures(state, agent).sensors
    assert sensors is not None
    value = sensors.compass[0].value
    assert value is not None
    return value


def _headings(state: State, steps: int) -> list[float]:
    found = []
    for _ in range(steps):
        found.append(_heading(state))
        state, _ = run(state, 1)
    return found


def test_compass_without_noise_is_the_heading() -> None:
    assert _heading(world({"a": cart(heading=2.5, compass=(Compass(id="c"),))})) == 2.5


def test_heading_of_half_a_turn_is_pi_and_noise_stays_in_range() -> None:
    state = world({"a": cart(heading=math.pi, compass=(Compass(id="c", noise_deg=3.0),))})
    found = np.array(_headings(state, 60))
    assert (found > -math.pi).all()
    assert (found <= math.pi).all()
    # About half of them went over.
    assert 10 < (found < 0.0).sum() < 50


def test_noise_is_gaussian_with_the_declared_deviation() -> None:
    state = world({"a": cart(compass=(Compass(id="c", noise_deg=2.0),))})
    found = np.degrees(_headings(state, 400))
    # Five standard errors of 400 draws.
    assert abs(found.mean()) < 5 * 2.0 / 20
    assert found.std() == pytest.approx(2.0, abs=5 * 2.0 / math.sqrt(800))


def test_steps_round_to_the_nearest() -> None:
    for heading, expected in ((0.5, 0.0), (1.01, 2.0), (-3.0, -2.0), (179.5, 180.0), (-179.5, 180.0)):
        state = world({"a": cart(heading=math.radians(heading), compass=(Compass(id="c", step_deg=2.0),))})
        assert math.degrees(_heading(state)) == pytest.approx(expected, abs=math.degrees(ROUNDED))


def test_noise_of_one_agent_does_not_depend_on_who_else_is_there() -> None:
    compass = Compass(id="c", noise_deg=2.0)
    alone = world({"b": cart(compass=(compass,))})
    company = world(
        {
            "a": cart(5.0, compass=(compass,)),
            "b": cart(compass=(compass, Compass(id="d", noise_deg=2.0))),
            "c": cart(9.0),
        }
    )
    for _ in range(5):
        assert _heading(alone, "b") == _heading(company, "b")
        assert _heading(company, "a") != _heading(company, "b")
        alone, _ = run(alone, 1)
        company, _ = run(company, 1)


def test_another_seed_gives_other_noise() -> None:
    robot = cart(compass=(Compass(id="c", noise_deg=2.0),))
    assert _heading(world({"a": robot}, seed="1")) != _heading(world({"a": robot}, seed="2"))


def test_bias_walks_and_stays_in_range() -> None:
    state = world({"a": cart(heading=math.pi, compass=tuple(Compass(id=f"c{k}", walk_deg=5.0) for k in range(60)))})
    assert _heading(state) == math.pi
    state, _ = run(state, 80)
    sensors = measures(state, "a").sensors
    assert sensors is not None
    found = np.array([reading.value for reading in sensors.compass], dtype=np.float64)
    assert (np.abs(found) <= math.pi).all()
    walked = np.degrees(np.mod(found, 2 * math.pi) - math.pi)
    # 5 deg a root second for 4 s; four standard errors of 60 walks.
    assert walked.std() == pytest.approx(10.0, rel=0.37)
