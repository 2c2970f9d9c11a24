from __future__ import annotations

import math
import random
from itertools import pairwise

import msgspec
import numpy as np
import pytest

from intellwheels_maps import floor, robot
from intellwheels_schemas.codec import encode
from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.messages import Actions, Entity, Goal
from intellwheels_server.world import Setup, State, advance, apply, begin, entities, state_writer
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.state_writer import StateWriter, WrittenState


def crowd() -> State:
    """Return a world with chairs."""
    kinds = ("rear-wheel", "mid-wheel", "rear-wheel", "front-wheel")
    joins = [Join(agent=f"a{k}", robot=robot(kind)) for k, kind in enumerate(kinds)]
    state, outputs = apply(begin(Setup(floor=floor("ward")), "0" * 16), joins)
    assert all(one.code == "ok" for one in outputs.outcomes)
    return state


def stirred(state: State, draw: random.Random) -> State:
    """Return the state with any numbers and flags."""
    numbers, flags = state.numbers.copy(), state.flags.copy()
    for i in range(len(state.names)):
        numbers[rows.X, i], numbers[rows.Y, i] = draw.uniform(-1e4, 1e4), draw.choice((0.0, -1e-7, 5e-6))
        numbers[rows.HEADING, i] = draw.choice((draw.uniform(-math.pi, math.pi), math.pi, -math.pi + 1e-9, -0.0))
        numbers[rows.SPEED, i] = draw.choice((draw.uniform(-100.0, 100.0), -1e-9, 0.0, 1e-6))
        numbers[rows.TURN_RATE, i] = draw.choice((draw.uniform(-1000.0, 1000.0), 0.0))
        numbers[rows.LEFT_SPEED, i], numbers[rows.RIGHT_SPEED, i] = draw.uniform(-3, 3), draw.choice((0.0, 0.3))
        numbers[rows.TOUCHING, i] = draw.random() < 0.5
    for row in (rows.COLLISION, rows.TIMED_OUT, rows.RESTED, rows.HALTED, rows.TAKEN, rows.STALE):
        flags[row] = [draw.random() < 0.3 for _ in state.names]
    flags[rows.CONTACTS] = [draw.choice((0, 1, 12_345_678)) for _ in state.names]
    return msgspec.structs.replace(state, numbers=numbers, flags=flags)


def listed(written: WrittenState | None) -> list[bytes]:
    """Return the bytes of each entity."""
    assert written is not None
    ends = written.ends
    return [written.data[begin : end - 1] for begin, end in pairwise(ends)]


def test_every_field_is_written_here_and_nothing_as_long_as_one_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    assert set(Entity.__struct_fields__) == state_writer.WRITTEN
    monkeypatch.setattr(state_writer, "_KNOWS_ALL", False)
    state = crowd()
    assert StateWriter().write(state, {}, np.zeros((2, len(state.names)))) is None


def test_the_bytes_are_those_of_the_codec() -> None:
    draw, writer, state = random.Random(5), StateWriter(), crowd()
    mind = Actions(left_motor=0.3, right_motor=0.2, mode="seek", goal=Goal(x=1.0, y=2.0, heading=0.5))
    for tick in range(80):
        said = {"a1": Actions(say='"hé" \\ <')} if tick == 5 else {}
        state, _ = advance(state, Inputs(actions=said | ({"a0": mind} if tick % 10 == 2 else {})))
        shown = stirred(state, draw)
        ages = {"a0": 0.05, "nobody": 1.0} if tick % 2 else {}
        paths = np.array([[draw.uniform(0, 1e4) for _ in state.names], [draw.uniform(0, 3) for _ in state.names]])
        paths[:, 3] = math.nan
        expected: list[Entity] = []
        for one, length, turned in zip(entities(shown), *paths.round(6).tolist(), strict=True):
            counted = {} if math.isnan(length) else {"travelled": length, "turned": turned}
            expected.append(msgspec.structs.replace(one, command_age=ages.get(one.name, 0.0), **counted))
        assert listed(writer.write(shown, ages, paths)) == [encode(one) for one in expected]
    assert state.statuses["a1"].say is not None


def test_a_number_that_is_too_long_is_left_to_the_codec() -> None:
    state = crowd()
    assert StateWriter().write(state, {}, np.full((2, len(state.names)), 1e12)) is None


def test_a_world_without_bodies_is_empty() -> None:
    state = begin(Setup(floor=floor("ward")), "0" * 16)
    assert StateWriter().write(state, {}, np.empty((2, 0))) == WrittenState(b"", [0])
