from __future__ import annotations

import random
from typing import Any

import msgspec
import pytest

from intellwheels_maps import floor, robot
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.messages import (
    Actions,
    AgentMeasures,
    CrewMeasures,
    Measures,
    Pose,
    Proximity,
    ProximityReading,
    Robot,
    Sensors,
    UserInput,
)
from intellwheels_schemas.rules import SENSOR_KINDS, SENSOR_RECORDS
from intellwheels_schemas.shapes import Form, shape_of
from intellwheels_server.world import Setup, State, advance, apply, begin, measures, measures_writer
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.measures_writer import MeasuresWriter
from intellwheels_server.world.sensors.catalogue import KINDS, example_sensors
from intellwheels_server.world.sensors.kind import Kind

FLOOR = floor("ward")


def equipped(draw: random.Random, *, lidar: bool) -> dict[str, Any]:
    """Return some sensors of every kind, with rates and latencies."""
    found: dict[str, Any] = {}
    every: dict[str, tuple[Any, ...]] = dict(example_sensors(FLOOR))
    for field, examples in every.items():
        if draw.random() < 0.3 or (field == "lidar" and not lidar):
            continue
        found[field] = tuple(
            msgspec.structs.replace(one, id=f"{one.id}-{k}", **({} if draw.random() < 0.5 else _timed(draw, one)))
            for k, one in enumerate(examples)
        )
    return found


def _timed(draw: random.Random, one: Any) -> dict[str, int]:
    if getattr(one, "model", "") == "sonar":
        return {}
    return {"every": draw.randint(1, 3), "latency": draw.randint(0, 4)}


def crowd(draw: random.Random) -> State:
    """Return a world that robots of all sorts have joined at several ticks."""
    state = begin(Setup(floor=FLOOR, truth=True, say_loss=0.2), "0123456789abcdef")
    drive = {}
    for number in range(6):
        name = f"a{number}"
        body = robot(draw.choice(("rear-wheel", "mid-wheel")))
        fields = equipped(draw, lidar=number == 0) if number else {}
        body = msgspec.structs.replace(body, **dict.fromkeys(SENSOR_KINDS, ()))
        wants = ("drive", "words") if number % 2 else ()
        body = msgspec.structs.replace(body, user_input=wants, **fields)
        state, outputs = apply(state, [Join(agent=name, robot=body)])
        assert outputs.outcomes[0].code == "ok", outputs.outcomes[0].text
        drive[name] = Actions(left_motor=draw.uniform(-1, 1), right_motor=draw.uniform(-1, 1))
        state, _ = advance(state, Inputs(actions=drive))
    return state


def stirred(state: State, draw: random.Random) -> State:
    """Return the state with any flags, and with any codes and numbers in place of its samples."""
    samples = state.samples.copy()
    for fitting in state.body_set.plan.fittings:
        for _, places in fitting.fields:
            for reading, sensor, first, width, depth, *_ in places:
                written = KINDS[type(sensor.declaration)].written(sensor)
                if written is None:
                    continue
                for at in range(fitting.begin + first, fitting.begin + first + width * depth):
                    column = (at - fitting.begin - first) % width
                    if written.codes and column == 0:
                        samples[at] = written.lowest + draw.randrange(written.codes)
                    elif "encoders" in str(reading):
                        samples[at] = draw.randint(-(2**53), 2**53) if draw.random() < 0.5 else draw.randint(-3, 3)
                    else:
                        samples[at] = _number(draw)
    flags, numbers = state.flags.copy(), state.numbers.copy()
    for row in (rows.COLLISION, rows.TIMED_OUT, rows.RESTED, rows.HALTED, rows.TAKEN, rows.STALE):
        flags[row] = [draw.random() < 0.3 for _ in state.names]
    numbers[rows.TOUCHING] = [draw.random() < 0.5 for _ in state.names]
    return msgspec.structs.replace(state, samples=samples, flags=flags, numbers=numbers)


def _number(draw: random.Random) -> float:
    """Return a number as sensors round them."""
    exact = draw.choice((0.0, 1e-6, 9e-6, 1e-5, 0.5, draw.uniform(-4, 4), draw.uniform(-1e4, 1e4), 3.1415926,
                         -3.1415928, draw.uniform(-1e8, 1e8), draw.uniform(-1e12, 1e12)))  # fmt: skip
    return round(exact, 6) + 0.0


def expected(state: State, agent: str, encoding: Encoding, *, named: bool) -> bytes:
    """Return what the codec writes of the message."""
    message = measures(state, agent)
    if not named:
        return encode(message, encoding)
    fields = {name: getattr(message, name) for name in message.__struct_fields__}
    data = encode(CrewMeasures(crew="c", measures=(AgentMeasures(agent=agent, **fields),)), encoding)
    if encoding is Encoding.JSON:
        return data[data.index(b"[") + 1 : -2]
    return data[data.index(b">") + 1 : -len("</CrewMeasures>")]


@pytest.mark.parametrize("named", [False, True])
@pytest.mark.parametrize("encoding", list(Encoding))
def test_the_bytes_are_those_of_the_codec(encoding: Encoding, named: bool) -> None:
    draw = random.Random(f"{encoding}{named}")
    state = crowd(draw)
    writer = MeasuresWriter(encoding, named=named)
    agents = tuple(state.names)
    for round_ in range(30):
        words = Actions(left_motor=0.1, right_motor=-0.1, say='<héllo & ]]> "you"\n')
        said = {"a2": words} if round_ % 3 == 0 else {}
        users = {name: UserInput(forward=0.5, word="left") for name in ("a0", "a1")} if round_ == 10 else {}
        state, _ = advance(state, Inputs(actions=said, user_input=users))
        shown = stirred(state, draw)
        found = writer.write(shown, agents)
        assert found == [expected(shown, name, encoding, named=named) for name in agents]
    assert any(state.user), "no input of a user was written"


@pytest.mark.parametrize("encoding", list(Encoding))
def test_agents_may_come_and_go_and_be_any_of_the_bodies(encoding: Encoding) -> None:
    state = crowd(random.Random(4))
    writer = MeasuresWriter(encoding)
    for agents in (("a4", "a1"), (), ("a1",), ("a3", "a2", "a1", "a5")):
        assert writer.write(state, agents) == [encode(measures(state, name), encoding) for name in agents]
    with pytest.raises(KeyError):
        writer.write(state, ("nobody",))


def test_what_a_real_body_forwards_is_written_too() -> None:
    eye = Proximity(id="p", x=0.5, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, max_range=4.0)
    own = msgspec.structs.replace(eye, id="q", source="real")
    bare = msgspec.structs.replace(robot("rear-wheel"), **dict.fromkeys(SENSOR_KINDS, ()))
    real: Robot = msgspec.structs.replace(bare, type="real", proximity=(eye, own))
    state, _ = apply(begin(Setup(floor=FLOOR), "0" * 16), [Join(agent="r", robot=real), Join(agent="s", robot=bare)])
    for encoding in Encoding:
        writer = MeasuresWriter(encoding, named=True)
        readings = Sensors(proximity=(ProximityReading(id="q", value=1.25),))
        pose = Pose(x=1.0, y=1.0, heading=0.0, sensors=readings)
        after, _ = advance(state, Inputs(poses={"r": pose}))
        assert after.forwarded
        found = writer.write(after, ("r", "s"))
        assert found == [expected(after, name, encoding, named=True) for name in ("r", "s")]


def test_every_field_is_written_the_quick_way() -> None:
    # With another field everything is right, but each message is made as a record: this must be a choice.
    assert set(Measures.__struct_fields__) == measures_writer.WRITTEN


def test_a_field_that_the_writer_does_not_know_is_written_through_messages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measures_writer, "_KNOWS_ALL", False)
    state = crowd(random.Random(4))
    found = MeasuresWriter(Encoding.JSON).write(state, tuple(state.names))
    assert found == [encode(measures(state, name)) for name in state.names]


def test_every_kind_is_written_without_a_reading_unless_a_reading_has_lists() -> None:
    lists = [
        field
        for field, records in SENSOR_RECORDS.items()
        if any(member.form in {Form.LIST, Form.RECORDS} for member in shape_of(records.reading).members)
    ]
    assert [kind.field for kind in KINDS.values() if type(kind).written is Kind.written] == lists
