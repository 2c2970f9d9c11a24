"""Many worlds at once are equal to the bit to each of them alone."""

from __future__ import annotations

import random
from typing import Any

import msgspec
import numpy as np
import pytest

from intellwheels_maps import robot
from intellwheels_schemas.file_records import Depart, Inputs, Said, Verdict
from intellwheels_schemas.messages import (
    Actions,
    Compass,
    Encoders,
    End,
    Lidar,
    Odometry,
    Position,
    Proximity,
    Robot,
    Timeout,
    UserInput,
    Wall,
)
from intellwheels_server.world import Outputs, State, advance, digest, measures
from intellwheels_server.world.many_worlds import Worlds, advance_many, stack
from tests.server.worlds import box_wall, cart, floor_of, run, world

WALLS = [box_wall(-3.0, 1.6, 3.0, 1.8), box_wall(-3.0, -1.8, 3.0, -1.6)]
CONE = Proximity(id="ahead", x=0.5, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, max_range=4.0)
SENSORS: dict[str, Any] = {
    "proximity": (CONE, Proximity(**{**msgspec.structs.asdict(CONE), "id": "ir", "model": "infrared", "every": 2})),
    "odometry": (Odometry(id="o"),),
    "encoders": (Encoders(id="e", drift=1e-4),),
    "compass": (Compass(id="c", noise_deg=2.0, walk_deg=1.0),),
    "lidar": (Lidar(id="l", x=0.0, y=0.0, z=0.4, direction_deg=0.0, rays=5, fov_deg=90.0, max_range=5.0, noise=0.01),),
}


def two_chairs(seed: int, **settings: Any) -> State:
    """Return a world in which two noisy chairs of its own drive towards each other."""
    draw = random.Random(seed)
    chairs = {
        name: cart(
            x + draw.uniform(-0.2, 0.2), draw.uniform(-0.5, 0.5), heading + draw.uniform(-0.3, 0.3),
            width=draw.uniform(0.5, 0.7), top_speed=draw.uniform(0.6, 1.4), motor_noise=0.05, **SENSORS,
        )
        for name, x, heading in (("left", -1.5, 0.0), ("right", 1.5, 3.1))
    }  # fmt: skip
    return world(chairs, WALLS, **{"seed": str(seed), **settings})


def one_chair(seed: int = 1, **fields: Any) -> State:
    return world({"a": cart(motor_noise=0.05, **fields)}, WALLS, seed=str(seed))


def same(single: State, state: State) -> bool:
    """Return whether two states are equal to the bit in what they are and in what their agents get."""
    return (
        digest(single) == digest(state)
        and single.samples.tobytes() == state.samples.tobytes()
        and single.episodes.tolist() == state.episodes.tolist()
        and all(measures(single, name) == measures(state, name) for name in single.names)
        and (single.tick, single.event_count, single.statuses, single.heard, single.coming, single.ended)
        == (state.tick, state.event_count, state.statuses, state.heard, state.coming, state.ended)
    )


@pytest.mark.parametrize("threads", [1, 2])
def test_noise_sensors_and_contacts_are_those_of_each_world_alone(threads: int) -> None:
    alone = [two_chairs(seed) for seed in range(6)]
    alone[2], _ = run(alone[2], 3)  # its tick differs
    worlds = stack(alone)
    draw = np.random.default_rng(1)
    seen = set()
    for tick in range(80):
        commands = draw.uniform(0.0, 1.0, (6, 2, 2))
        commands[tick % 6, 0] = np.nan  # one chair keeps its command
        commands[:, :, 0][draw.random((6, 2)) < 0.1] = np.nan  # only one motor is told
        worlds, found = advance_many(worlds, commands=commands, threads=threads)
        for k, state in enumerate(alone):
            alone[k], outputs = advance(state, Inputs(actions=actions(commands[k])))
            assert found.get(k, Outputs()) == outputs
            seen |= {event.code for event in outputs.events}
            assert same(alone[k], worlds.state(k))
    assert seen >= {"contact", "parted"}


def actions(commands: Any) -> dict[str, Actions]:
    """Return the actions that an array of commands stands for; NaN is a motor that is left out."""
    left, right = ([None if np.isnan(power) else power for power in pair] for pair in commands.tolist())
    return {
        "left": Actions(left_motor=left[0], right_motor=left[1]),
        "right": Actions(left_motor=right[0], right_motor=right[1]),
    }


def test_inputs_of_every_kind_act_on_their_world_only() -> None:
    alone = [two_chairs(seed, strict=True, say_delay=0.1) for seed in range(4)]
    worlds = stack(alone)
    drive = Actions(left_motor=0.4, right_motor=0.5)
    told: list[dict[int, Inputs]] = [
        {0: Inputs(actions={"left": msgspec.structs.replace(drive, say="hello", mode="lost")}), 1: Inputs()},
        {
            2: Inputs(user_input={"left": UserInput(forward=1.0)}),
            3: Inputs(verdicts=(Verdict(agent="left", code="rested"),)),
        },
        {1: Inputs(says=(Said(agent="right", text="door"),)), 0: Inputs(actions={"left": drive, "nobody": drive})},
    ]  # fmt: skip
    codes = set()
    for tick in range(20):  # so long that users fall silent and commands time out
        inputs = told[tick] if tick < len(told) else {}
        worlds, found = advance_many(worlds, inputs)
        for k, state in enumerate(alone):
            alone[k], outputs = advance(state, inputs.get(k, Inputs()))
            assert found.get(k, Outputs()) == outputs
            codes |= {event.code for event in outputs.events}
            assert same(alone[k], worlds.state(k))
            assert alone[k].user == worlds.state(k).user
    assert codes >= {"rested", "timeout"}


def test_worlds_are_values_and_one_of_them_can_begin_again() -> None:
    states = [one_chair(seed, **SENSORS) for seed in range(3)]
    before = stack(states)
    full = np.ones((3, 1, 2))
    after, _ = advance_many(before, commands=full)
    assert [digest(before.state(k)) for k in range(3)] == [digest(state) for state in states]
    fresh = one_chair(9, **SENSORS)
    again = after.replaced({1: fresh})
    assert same(fresh, again.state(1))
    assert same(after.state(0), again.state(0))
    kept = digest(after.state(1))
    moved, _ = advance_many(again, commands=full)
    expected, _ = advance(fresh, Inputs(actions={"a": Actions(left_motor=1.0, right_motor=1.0)}))
    assert same(expected, moved.state(1))
    assert digest(after.state(1)) == kept


def test_a_world_whose_run_has_ended_goes_no_further() -> None:
    state = world({"a": cart()}, WALLS, end=End(timeout=Timeout(seconds=0.05)))
    worlds, found = advance_many(stack([one_chair(), state]))
    assert list(found) == [1]
    assert found[1].ended
    with pytest.raises(RuntimeError, match="world 1: run 0123456789abcdef ended at tick 1"):
        advance_many(worlds)
    with pytest.raises(ValueError, match="world 0: expected a run that goes on"):
        stack([worlds.state(1)])


TABLE = msgspec.structs.replace(robot("table"), position=Position(x=0.0, y=0.0, heading=0.0))


@pytest.mark.parametrize(
    ("name", "body", "walls", "settings", "text"),
    [
        ("a", cart(), WALLS, {"period": 0.1}, "the period of the first world, 0.05, got 0.1"),
        ("a", cart(), WALLS, {"strict": True}, "the strict of the first world, False, got True"),
        ("b", cart(), WALLS, {}, "bodies a, got b"),
        ("a", cart(), WALLS[:1], {}, "the walls of the first world"),
        ("a", TABLE, WALLS, {}, "as many parts of each body"),
        ("a", cart(odometry=(Odometry(id="o"),)), WALLS, {}, "sensors laid out as in the first world"),
    ],
)
def test_worlds_that_cannot_stand_together_are_named(
    name: str, body: Robot, walls: list[Wall], settings: dict[str, Any], text: str
) -> None:
    other, worlds = world({name: body}, walls, **settings), stack([one_chair()])
    with pytest.raises(ValueError, match=f"world 1: expected .*{text}"):
        stack([one_chair(), other])
    with pytest.raises(ValueError, match=f"world 0: expected .*{text}"):
        worlds.replaced({0: other})


def test_wrong_arguments_are_named() -> None:
    worlds: Worlds = stack([one_chair(), one_chair(2)])
    with pytest.raises(ValueError, match="states: expected at least one"):
        stack([])
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"threads": 0}, "threads: expected a whole number from 1, got 0"),
        ({"threads": True}, "threads: expected a whole number from 1, got True"),
        ({"inputs": {2: Inputs()}}, "inputs: expected worlds from 0 to 1, got 2"),
        ({"inputs": {0: Inputs(changes=(Depart(agent="a"),))}}, r"inputs\[0\]: expected no changes"),
        ({"commands": np.zeros((2, 2))}, r"commands: expected float64\[2, 1, 2\], got float64\[2, 2\]"),
        ({"commands": [[0.0]]}, r"commands: expected float64\[2, 1, 2\], got \[\[0.0\]\]"),
        ({"commands": np.array([[[0.0, 0.0]], [[0.0, 1.5]]])}, r"commands\[1, 0, 1\]: expected a power in .*, got 1.5"),
    ]  # fmt: skip
    for arguments, text in wrong:
        with pytest.raises(ValueError, match=text):
            advance_many(worlds, **arguments)


def test_two_threads_share_worlds_of_which_there_are_fewer() -> None:
    worlds, _ = advance_many(stack([one_chair()]), threads=8)
    assert same(advance(one_chair(), Inputs())[0], worlds.state(0))
    assert floor_of(WALLS) == worlds.state(0).setup.floor
