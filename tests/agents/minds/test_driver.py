"""The model of a driver: its reaction time and its tremor."""

from __future__ import annotations

import math
import random
import statistics
from itertools import pairwise

import msgspec
import pytest

from intellwheels_agents.minds.driver import FELT, GLANCE, HAND, TURNED, Glances, Mind, Tremor, equip
from intellwheels_agents.options import OptionError, Options
from intellwheels_maps import robot
from intellwheels_schemas.messages import CompassReading, GPSReading, Measures, Position, Sensors, TruthReading
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


def by_glances(seed: str, options: dict[str, str], seconds: float, period: float = 0.05) -> tuple[Arena, Mind]:
    arena = Arena("corridor15m", seed, period)
    wanted = {**WAY, "eyes": "glances", **options}
    mind = arena.join("chair", "driver", "corridor-chair", "start", wanted).mind
    assert isinstance(mind, Mind)
    arena.run(seconds, until=lambda now: math.dist(now.paths["chair"][-1][:2], (15.0, 0.0)) < 0.4)
    return arena, mind


def test_driver_who_judges_the_pose_gets_no_truth_and_passes_the_corridor() -> None:
    equipped = equip(robot("corridor-chair"), Options({"eyes": "glances", "glance_m": "0.2", "glance_deg": "4"}))
    assert equipped.truth == ()
    assert [(one.id, one.noise) for one in equipped.gps[-2:]] == [(HAND, 1.0), (GLANCE, 0.2)]
    assert (equipped.compass[-1].id, equipped.compass[-1].noise_deg) == (TURNED, 4.0)
    assert equipped.encoders == robot("corridor-chair").encoders
    bare = msgspec.structs.replace(robot("corridor-chair"), encoders=(), odometry=())
    assert [one.id for one in equip(bare, Options({"eyes": "glances"})).encoders] == [FELT]
    arena, _ = by_glances("1", {}, 60.0)
    assert math.dist(arena.paths["chair"][-1][:2], (15.0, 0.0)) < 0.4
    assert arena.contacts() == []


@pytest.mark.parametrize("period", [0.02, 0.05, 0.1])
def test_error_of_a_glance_makes_the_stated_error_at_any_period(period: float) -> None:
    body = msgspec.structs.replace(robot("corridor-chair"), odometry=())
    noise = random.Random(5)
    glances = Glances(body, Position(x=0.0, y=0.0, heading=0.0), 0.3, period)
    errors, turns = [], []
    for tick in range(round(600.0 / period)):
        sensors = Sensors(
            gps=(GPSReading(id=GLANCE, x=1.0 + noise.gauss(0.0, 0.1), y=noise.gauss(0.0, 0.1)),),
            compass=(CompassReading(id=TURNED, value=noise.gauss(0.0, 0.05)),),
        )
        glances.update(sensors)
        if tick * period > 5.0:
            errors += [glances.believed.x - 1.0, glances.believed.y]
            turns.append(glances.believed.heading)
    # sqrt(0.3 / 1.7) of the error of a glance; 4,000 glances of which some six are one: three times their sd.
    assert statistics.pstdev(errors) == pytest.approx(0.042, rel=0.12)
    assert statistics.pstdev(turns) == pytest.approx(0.021, rel=0.15)


def test_driver_feels_the_motion_between_glances() -> None:
    arena, mind = by_glances("1", {"glance": "10", "glance_m": "0", "glance_deg": "0", "tremor": "0"}, 8.0)
    x, y, heading = arena.paths["chair"][-1]
    assert x > 2.0
    assert (mind.seen.x, mind.seen.y) == pytest.approx((x, y), abs=0.05)
    assert mind.seen.heading == pytest.approx(heading, abs=0.05)


def test_path_is_required() -> None:
    with pytest.raises(OptionError, match="options: expected at least one of points and to, got none"):
        Mind(context(robot("corridor-chair")))
