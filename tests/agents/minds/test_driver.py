"""The model of a driver: its reaction time and its tremor."""

from __future__ import annotations

import math
import random
import statistics
from itertools import pairwise

import pytest

from intellwheels_agents.minds.driver import HAND, Mind, Tremor, equip
from intellwheels_agents.options import OptionError, Options
from intellwheels_maps import robot
from intellwheels_schemas.messages import GPSReading, Measures, Sensors, TruthReading
from tests.agents.arena import Arena
from tests.agents.kinematics import context

WAY = {"points": "3.2 0.3 5.4 0.5 7.0 0.2 8.6 -0.3 10.4 -0.5 12.4 -0.1", "to": "goal", "MotorNoise": "0.015"}


def seen(tick: int, x: float = 0.0, y: float = 0.0) -> Measures:
    truth = TruthReading(id="eyes", x=x, y=y, heading=0.0, speed=0.0, turn_rate=0.0)
    sensors = Sensors(truth=(truth,), gps=(GPSReading(id=HAND, x=x, y=y),))
    return Measures(run="0" * 16, tick=tick, time=tick * 0.05, sensors=sensors)


def driven(seed: str) -> Arena:
    arena = Arena("corridor15m", seed)
    arena.join("chair", "driver", "corridor-chair", "start", WAY)
    arena.run(60.0, until=lambda now: math.dist(now.paths["chair"][-1][:2], (15.0, 0.0)) < 0.2)
    return arena


def test_driver_passes_the_corridor_without_contact() -> None:
    arena = driven("1")
    assert math.dist(arena.paths["chair"][-1][:2], (15.0, 0.0)) < 0.2
    assert arena.contacts() == []


def test_hand_follows_from_the_seed_of_the_run() -> None:
    first, again, other = (driven(seed).paths["chair"] for seed in ("1", "1", "2"))
    assert first == again
    assert first != other


def test_hand_moves_after_the_reaction_time() -> None:
    mind = Mind(context(robot("corridor-chair"), points="5 0", reaction="0.3", tremor="0"))
    powers = [mind.decide(seen(tick)).left_motor for tick in range(8)]
    assert powers[:6] == [0.0] * 6
    assert powers[6] is not None
    assert powers[6] > 0.3


def test_tremor_has_the_given_size_and_frequency() -> None:
    noise = random.Random(3)
    tremor = Tremor(0.05, 5.0, 0.05)
    values = [tremor.next(noise.gauss(0.0, 1.0)) for _ in range(40_000)]
    # 40,000 samples of which some ten are one: the sd is known to 1 %, and three of these are allowed.
    assert statistics.pstdev(values) == pytest.approx(0.05, rel=0.03)
    rises = sum(a < 0.0 <= b for a, b in pairwise(values))
    assert rises / (len(values) * 0.05) == pytest.approx(5.0, rel=0.05)


def test_eyes_and_hand_are_added_to_the_robot() -> None:
    equipped = equip(robot("corridor-chair"), Options())
    assert ([one.id for one in equipped.truth], [one.id for one in equipped.gps]) == (["eyes"], [HAND])


def test_path_is_required() -> None:
    with pytest.raises(OptionError, match="options: expected at least one of points and to, got none"):
        Mind(context(robot("corridor-chair")))
