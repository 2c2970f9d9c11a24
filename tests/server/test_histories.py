"""Whole lives of worlds, drawn at random: whatever happens, what comes out can be sent, and the log gives it again."""

from __future__ import annotations

import random
from typing import Any

import msgspec
import pytest

from intellwheels_maps import floor, names, robot
from intellwheels_schemas import file_records as do
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.messages import (
    Actions,
    Body,
    End,
    Event,
    Goal,
    Measures,
    Pose,
    Position,
    PowerInForce,
    Reach,
    Robot,
    Timeout,
    Truth,
    UserInput,
    WorldState,
)
from intellwheels_server.log.input_log import Line
from intellwheels_server.world import (
    Outputs,
    Setup,
    State,
    advance,
    apply,
    begin,
    digest,
    entities,
    measures,
    power_in_force,
)

AGENTS = [f"a{k}" for k in range(8)]
VERDICTS: list[Any] = ["late", "rested", "back", "silent", "stale", "fresh", "halt", "unhalt"]
TICKS = 120


def draw_setup(draw: random.Random) -> Setup:
    return Setup(
        floor=floor(draw.choice(names("floors"))),
        seed=str(draw.random()),
        period=draw.choice([0.02, 0.05, 0.1]),
        truth=draw.random() < 0.5,
        strict=draw.random() < 0.5,
        end=End(timeout=Timeout(seconds=5.0)) if draw.random() < 0.3 else None,
    )


def draw_robot(draw: random.Random, position: Position) -> Robot:
    fields: dict[str, Any] = {}
    if draw.random() < 0.2:
        fields.update(type="real", proximity=())
    if draw.random() < 0.3:
        fields.update(truth=(Truth(id="t", every=draw.randint(1, 5), latency=draw.randint(0, 4)),))
    if draw.random() < 0.3:
        fields.update(motor_noise=0.1)
    if draw.random() < 0.5:
        fields.update(position=position)
    return msgspec.structs.replace(robot(draw.choice(names("robots"))), **fields)


def draw_change(draw: random.Random) -> do.Change:
    agent = draw.choice(AGENTS)
    position = Position(x=draw.uniform(0.0, 12.0), y=draw.uniform(-1.0, 8.0), heading=draw.uniform(-3.0, 3.0))
    reach = Reach(agent="a1", place=draw.choice(["nowhere", "goal1"]), within=0.3)
    kinds: list[tuple[float, do.Change]] = [
        (0.40, do.Join(agent=agent, robot=draw_robot(draw, position))),
        (0.05, do.Join(agent=agent, robot=Robot(role="mind", user_input=("drive",)))),
        (0.10, do.Depart(agent=agent, role=draw.choice(["both", "mind", "body"]), lost=draw.random() < 0.5)),
        (0.15, do.TeleportBody(agent=agent, position=position, force=draw.random() < 0.6)),
        (0.05, do.SpawnBody(robot=msgspec.structs.replace(robot("crate"), name=agent), position=position)),
        (0.05, do.DeleteBody(agent=agent)),
        (0.05, do.TakeBody(agent=agent, on=draw.random() < 0.6)),
        (0.05, do.Speech(text="hi", to=draw.choice([None, agent]))),
        (0.03, do.Note(code="speed", speed=2.0)),
        (
            0.03,
            do.Restart(
                run=f"{draw.getrandbits(64):016x}",
                seed=str(draw.random()),
                map=floor(draw.choice(names("floors"))) if draw.random() < 0.5 else None,
                end=End(reach=(reach,)) if draw.random() < 0.3 else None,
            ),
        ),
        (0.04, do.GoOn()),
    ]
    return draw.choices([change for _, change in kinds], [weight for weight, _ in kinds])[0]


def draw_inputs(draw: random.Random, tick: int) -> do.Inputs:
    def some(share: float) -> list[str]:
        return [agent for agent in AGENTS if draw.random() < share]

    return do.Inputs(
        changes=tuple(draw_change(draw) for _ in range(draw.choice([0, 0, 0, 1, 2]))),
        actions={
            agent: Actions(
                left_motor=draw.choice([None, draw.uniform(-1.0, 1.0)]),
                right_motor=draw.uniform(-1.0, 1.0),
                say=draw.choice([None, None, "hello"]),
                mode=draw.choice([None, "m"]),
                goal=draw.choice([None, Goal(x=1.0, y=2.0)]),
                seq=tick,
            )
            for agent in some(0.7)
        },
        says=tuple(do.Said(agent=agent, text="yo") for agent in some(0.05)),
        poses={
            agent: Pose(x=draw.uniform(0.0, 12.0), y=draw.uniform(0.0, 8.0), heading=draw.uniform(-6.0, 6.0))
            for agent in some(0.3)
        },
        user_input={
            agent: UserInput(forward=draw.uniform(-1.0, 1.0), turn=draw.uniform(-1.0, 1.0), seq=tick)
            for agent in some(0.1)
        },
        verdicts=tuple(do.Verdict(agent=agent, code=draw.choice(VERDICTS)) for agent in some(0.05)),
    )


def step(state: State, inputs: do.Inputs) -> tuple[do.Inputs, State, Outputs]:
    """Step, going on after an end; return the inputs that did it."""
    after, _ = apply(state, inputs.changes)
    if after.ended:
        inputs = msgspec.structs.replace(inputs, changes=(*inputs.changes, do.GoOn()))
    return inputs, *advance(state, inputs)


def check(state: State, outputs: Outputs) -> None:
    numbers = [event.number for event in outputs.events if event.run == state.run]
    assert numbers == sorted(set(numbers))
    for event in outputs.events:
        assert decode(Event, encode(event)) == event
    for name in state.names:
        told = measures(state, name)
        for encoding in (Encoding.JSON, Encoding.XML):
            assert decode(Measures, encode(told, encoding), encoding) == told
        decode(PowerInForce, encode(power_in_force(state, name)))
        decode(Body, encode(Body(run=state.run, tick=state.tick, robot=state.body_set.models[name].robot)))
    world = WorldState(run=state.run, tick=state.tick, time=state.time, entity=entities(state))
    assert decode(WorldState, encode(world)) == world


@pytest.mark.parametrize("seed", [*range(6), *(pytest.param(seed, marks=pytest.mark.soak) for seed in range(6, 24))])
def test_random_history_can_be_encoded_and_its_log_repeats_it(seed: int) -> None:
    draw = random.Random(seed)
    setup = draw_setup(draw)
    state = begin(setup, "0" * 16)
    lines = []
    for tick in range(TICKS):
        before = state.tick
        inputs, state, outputs = step(state, draw_inputs(draw, tick))
        check(state, outputs)
        lines.append(msgspec.json.encode(Line(tick=before, inputs=inputs, hash=digest(state))))
    again = begin(setup, "0" * 16)
    for line in lines:
        read = msgspec.json.decode(line, type=Line)
        again, _ = advance(again, read.inputs)
        assert digest(again) == read.hash
