"""What is recorded of each message."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from intellwheels_agents.record_gateway.translator import MOST_TOPICS, RETURNS, Translator
from intellwheels_maps import floor, robot
from intellwheels_schemas.codec import encode
from intellwheels_schemas.json_schema import json_schemas
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Body, Clock, Entity, Goal, Record, WorldState
from intellwheels_schemas.vectors import NAMES

RUN, OTHER = "0123456789abcdef", "fedcba9876543210"
KEYS = Keys("w")


class Time:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def clock(tick: int, run: str = RUN) -> Clock:
    return Clock(run=run, tick=tick, time=tick * 0.05, state="running", pace="realtime", hash=RUN, stamp=1.0)


def state(tick: int, *entities: Entity) -> WorldState:
    return WorldState(run=RUN, tick=tick, time=tick * 0.05, entity=entities)


def topics(translator: Translator, key: str, message: Record) -> list[str]:
    return [entry.topic for entry in translator.take(key, encode(message), "application/json")]


def test_a_body_in_the_state_has_transforms_and_poses() -> None:
    translator = Translator(KEYS, Time())
    chair = Body(run=RUN, tick=0, robot=robot("intellwheels"))
    assert topics(translator, KEYS.body("c"), chair) == ["/iw/body/c", "/scene"]
    found = topics(translator, KEYS.state(0), state(1, Entity(name="c", x=1, y=2, heading=0, goal=Goal(x=1, y=1))))
    assert found == ["/iw/state", "/tf", "/c/pose", "/c/truth", "/c/goal"]
    found = topics(translator, KEYS.state(0), state(2))
    assert found == ["/iw/state", "/scene"]
    assert translator.robots == {}


def test_a_body_that_is_unknown_is_asked_for() -> None:
    translator = Translator(KEYS, Time())
    translator.take(KEYS.clock, encode(clock(0)), "application/json")
    translator.wants_bodies = False
    translator.take(KEYS.state(0), encode(state(1, Entity(name="c", x=1, y=2, heading=0))), "application/json")
    assert translator.wants_bodies


def test_missed_ticks_are_reported_in_the_log() -> None:
    translator = Translator(KEYS, Time())
    topics(translator, KEYS.state(0), state(1))
    assert "/log" in topics(translator, KEYS.state(0), state(5))
    assert translator.ticks.missed == 3


def test_a_stranger_that_names_another_run_holds_the_recording_up_for_a_second_only() -> None:
    time = Time()
    translator = Translator(KEYS, time)
    assert topics(translator, KEYS.clock, clock(1)) == ["/iw/clock"]
    assert topics(translator, KEYS.clock, clock(1, OTHER)) == ["/iw/clock"]
    assert topics(translator, KEYS.clock, clock(2)) == []
    time.now += RETURNS
    assert topics(translator, KEYS.clock, clock(3)) == ["/iw/clock"]
    assert translator.times.run == RUN


def test_a_map_is_scene_grid_and_document() -> None:
    translator = Translator(KEYS, Time())
    found = translator.take_map(floor("room"))
    assert [entry.topic for entry in found] == ["/scene", "/grid", "/iw/map"]
    assert all(entry.keep for entry in found)


def test_every_document_that_is_recorded_has_a_schema() -> None:
    assert NAMES.keys() <= json_schemas(grows=True).keys()


@given(
    st.sampled_from(["state/0", "clock", "event", "map", "body/c", "out/c/measures", "in/c/pose", "user/c", "x/y"]),
    st.binary(max_size=200) | st.just(b"[" * 5000),
    st.sampled_from(["", "application/json", "application/xml"]),
)
def test_bytes_that_are_no_message_are_counted(key: str, data: bytes, encoding: str) -> None:
    translator = Translator(KEYS, Time())
    assert translator.take(KEYS.prefix + key, data, encoding) == [] or key == "user/c"


def test_topics_are_bounded() -> None:
    translator = Translator(KEYS, Time())
    for number in range(MOST_TOPICS + 5):
        translator.take(KEYS.user(f"c{number}"), b"{}", "application/json")
    assert translator.refused == 5


@pytest.mark.parametrize("encoding", ["application/json", "application/xml"])
def test_every_message_is_recorded_as_json(encoding: str) -> None:
    data = b'<UserInput Forward="0.5"/>' if encoding.endswith("xml") else b'{"Forward": 0.5}'
    (entry,) = Translator(KEYS, Time()).take(KEYS.user("c"), data, encoding)
    assert json.loads(entry.message) == {"Forward": 0.5}
