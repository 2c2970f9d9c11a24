"""Aided driving does as much of the user's wish as the obstacles allow: no contact, and always a way back.

In the real world, in one process. All four chairs look all around at 0.4 m; nothing on these floors is lower or hangs
higher than that alone.
"""

from __future__ import annotations

import itertools
import math
import random

import pytest

from intellwheels_agents.minds.aided import Mind, equip
from intellwheels_agents.navigation.collision_guard import CELL
from intellwheels_agents.navigation.obstacle_memory import CLEARING
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.range_scan import outline
from intellwheels_maps import robot
from intellwheels_schemas.file_records import Inputs
from intellwheels_schemas.messages import Actions, Measures, Robot, UserInput
from intellwheels_server.world import advance
from tests.agents.arena import Arena
from tests.agents.kinematics import RUN, context

CHAIRS = ("rear-wheel", "mid-wheel", "front-wheel", "intellwheels")
# Not the beds of the ward: a locker stands 0.15 m in front of the chair there, between the cones, and is never seen.
STARTS = (
    ("room", "start1"), ("room", "start3"), ("ward", "lobby1"), ("ward", "lobby2"),
    ("corner", "leader"), ("door", "start"), ("corridor15m", "start"),
)  # fmt: skip
SHORT = (0, 2, 3, 5)
"""The starts of the short version: each chair once, on three floors."""


def wish(arena: Arena, forward: float, turn: float, seconds: float) -> tuple[float, float]:
    """Apply a user input for so many seconds; return the distance from the start (m) and the angle turned (rad)."""
    arena.users["chair1"] = UserInput(forward=forward, turn=turn)
    first = len(arena.paths["chair1"]) - 1
    arena.run(seconds)
    path = arena.paths["chair1"][first:]
    turned = sum(math.remainder(b[2] - a[2], math.tau) for a, b in itertools.pairwise(path))
    return math.dist(path[0][:2], path[-1][:2]), turned


def stands(arena: Arena) -> bool:
    """Return whether a chair that has driven has stood for two seconds."""
    path = arena.paths["chair1"]
    return len(path) > 80 and path[-1][0] > path[0][0] + 1.0 and math.dist(path[-1], path[-41]) < 1e-5


def drive_at_random(arena: Arena, chance: random.Random, seconds: float) -> None:
    """Return random user inputs, mostly full ahead, that ignore all obstacles."""
    until = arena.state.tick * 0.05 + seconds
    while arena.state.tick * 0.05 < until:
        forward = chance.choice([1.0, 1.0, 0.6, 0.0, -0.7, chance.uniform(-1.0, 1.0)])
        turn = chance.choice([0.0, 0.0, 1.0, -1.0, chance.uniform(-1.0, 1.0), chance.uniform(-0.3, 0.3)])
        wish(arena, forward, turn, chance.uniform(0.3, 3.0))


def would_touch(arena: Arena, left: float, right: float, ticks: int) -> bool:
    """Return whether these powers, without aid, would lead into an obstacle."""
    state = arena.state
    for _ in range(ticks):
        state, outputs = advance(state, Inputs(actions={"chair1": Actions(left_motor=left, right_motor=right)}))
        if any(event.code == "contact" for event in outputs.events):
            return True
    return False


@pytest.mark.parametrize(
    ("start", "chair"),
    [
        pytest.param(start, CHAIRS[(start + turn) % 4], marks=[pytest.mark.soak] if turn or start not in SHORT else [])
        for start in range(len(STARTS))
        for turn in (0, 2)
    ],
)
def test_random_drives_touch_nothing(start: int, chair: str) -> None:
    floor, place = STARTS[start]
    arena = Arena(floor)
    arena.join("chair1", "aided", chair, place)
    drive_at_random(arena, random.Random(f"{chair} {2 * start}"), 6.0)
    assert arena.contacts() == []
    path = arena.paths["chair1"]
    assert sum(math.dist(a[:2], b[:2]) for a, b in itertools.pairwise(path)) > 0.5


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(56))
def test_long_random_drives_touch_nothing(seed: int) -> None:
    floor, place = STARTS[seed % len(STARTS)]
    arena = Arena(floor)
    arena.join("chair1", "aided", CHAIRS[seed % len(CHAIRS)], place)
    drive_at_random(arena, random.Random(seed), 60.0)
    assert arena.contacts() == []


@pytest.mark.parametrize(
    ("chair", "turn"),
    [
        pytest.param(chair, turn, marks=[pytest.mark.soak] if (turn > 0.0) == i % 2 else [])
        for i, chair in enumerate(CHAIRS)
        for turn in (1.0, -1.0)
    ],
)
def test_chair_slows_before_a_wall_then_turns_and_backs_up(chair: str, turn: float) -> None:
    arena = Arena("room")
    arena.join("chair1", "aided", chair, "start1", {"speed": "0.8"})
    wish(arena, 1.0, 0.0, 10.0)
    speeds = [math.dist(a[:2], b[:2]) / 0.05 for a, b in itertools.pairwise(arena.paths["chair1"])]
    assert max(speeds) > 0.6
    assert speeds[-1] < 0.2
    # Gently: never more than 0.15 m/s lost in a tick.
    assert all(b > a - 0.15 for a, b in itertools.pairwise(speeds))
    wish(arena, 0.0, 0.0, 1.0)
    assert arena.speed("chair1") == pytest.approx(0.0, abs=1e-3)
    assert arena.paths["chair1"][-1][0] > 7.0
    _, turned = wish(arena, 0.0, turn, 1.0)
    assert turned * turn > 0.3
    metres, _ = wish(arena, -1.0, 0.0, 1.5)
    assert metres > 0.3
    assert arena.contacts() == []


@pytest.mark.parametrize(
    "chair", [pytest.param(chair, marks=[pytest.mark.soak] if i % 2 else []) for i, chair in enumerate(CHAIRS)]
)
def test_chair_held_against_a_wall_creeps_stops_and_still_backs_up(chair: str) -> None:
    """The last centimetres take the room that its corners turn in: it turns a little, and all the way once back."""
    arena = Arena("room")
    arena.join("chair1", "aided", chair, "start1", {"speed": "0.8"})
    arena.users["chair1"] = UserInput(forward=1.0, turn=0.0)
    assert arena.run(28.0, stands) < 28.0
    assert arena.speed("chair1") == pytest.approx(0.0, abs=1e-3)
    _, turned = wish(arena, 0.0, 1.0, 1.0)
    assert turned > 0.03
    metres, _ = wish(arena, -1.0, 0.0, 1.5)
    assert metres > 0.3
    _, turned = wish(arena, 0.0, 1.0, 1.0)
    assert turned > 0.3
    assert arena.contacts() == []


def test_chair_held_against_a_wall_still_turns() -> None:
    arena = Arena("room")
    arena.join("chair1", "aided", "rear-wheel", "start1")
    wish(arena, 1.0, 0.0, 12.0)
    _, turned = wish(arena, 1.0, 0.6, 2.0)
    assert turned > 0.3
    assert arena.contacts() == []


@pytest.mark.parametrize("seeds", [(0,), pytest.param(tuple(range(1, 9)), marks=pytest.mark.soak)])
@pytest.mark.parametrize("chair", CHAIRS)
def test_chair_can_always_return_to_free_space(chair: str, seeds: tuple[int, ...]) -> None:
    asked = answered = 0
    for seed in seeds:
        floor, place = STARTS[(seed * 2 + CHAIRS.index(chair)) % len(STARTS)]
        arena = Arena(floor)
        arena.join("chair1", "aided", chair, place)
        chance = random.Random(seed)
        for _ in range(3):
            drive_at_random(arena, chance, 3.0)
            wish(arena, 0.0, 0.0, 0.5)
            if not would_touch(arena, -0.3, -0.3, 60):
                asked += 1
                answered += wish(arena, -1.0, 0.0, 1.5)[0] > 0.1
        assert arena.contacts() == []
    assert 3 * asked > 4 * len(seeds)
    assert answered == asked


def test_full_speed_where_there_is_room() -> None:
    arena = Arena("corridor15m")
    arena.join("chair1", "aided", "rear-wheel", "start")
    wish(arena, 0.5, 0.0, 2.0)
    assert arena.speed("chair1") == pytest.approx(0.4)


def test_chair_without_a_user_stands() -> None:
    mind = Mind(context(robot("rear-wheel")))
    actions = mind.decide(Measures(run=RUN, tick=0, time=0.0))
    assert (actions.left_motor, actions.right_motor) == (0.0, 0.0)
    assert equip(robot("rear-wheel"), Options()).user_input == ("drive", "words")


@pytest.mark.parametrize("chair", CHAIRS)
def test_cones_ahead_see_past_the_whole_strip_that_a_chair_drives_in(chair: str) -> None:
    """A point that no cone sees past stays in the way. At each side of the strip, 0.02 m are to spare."""
    body = equip(robot(chair), Options())
    half = outline(body).side + 0.0125 + 0.02
    for metres in (1.05, 1.2, 1.35, 1.5):
        seen = []
        for cone in body.proximity:
            s, c = math.sin(math.radians(cone.direction_deg)), math.cos(math.radians(cone.direction_deg))
            edge = math.radians(cone.cone_deg) / 2.0
            dx = outline(body).front + metres - cone.x
            for k in range(-50, 51):
                dy = half * k / 50.0 - cone.y
                along, across = c * dx + s * dy, abs(c * dy - s * dx)
                if along > 0.0 and across < along * math.tan(edge) - CLEARING * CELL / math.cos(edge):
                    seen.append(k)
        assert set(seen) == set(range(-50, 51))


def test_robot_without_encoders_is_refused() -> None:
    with pytest.raises(OptionError, match="mind aided: expected a robot with encoders, got one without"):
        Mind(context(Robot()))
