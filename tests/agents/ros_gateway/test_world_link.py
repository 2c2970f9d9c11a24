"""A world of the contract for the gateway, with a simulator that is only a table of answers."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from intellwheels_agents.ros_gateway.world_link import WorldQueries, WorldTopics
from intellwheels_maps import floor, robot
from intellwheels_schemas import link
from intellwheels_schemas.codec import encode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Body, Clock, Entity, Pause, Result, WorldState
from intellwheels_schemas.zenoh_inbox import Put
from tests.agents.ros_gateway.made_up import RUN

KEYS = Keys("w")
ONE, TWO = (Entity(name=name, x=1.0, y=2.0, heading=0.0) for name in ("a", "b"))


class Simulator:
    """Answers by key, and ends the gateway when it is asked for something twice."""

    def __init__(self) -> None:
        self.answers: dict[str, list[link.Answer]] = {}
        self.subscribed: dict[str, Any] = {}

    def put(self, key: str, *messages: Any, ok: bool = True) -> None:
        self.answers[key] = [link.Answer(key, encode(one), "application/json", ok) for one in messages]

    def query(self, _session: Any, key: str, *_data: Any, **_options: Any) -> list[link.Answer]:
        if key not in self.answers:
            raise ConnectionError(f"no simulator at {key}, or not allowed")
        return self.answers[key]

    @contextmanager
    def declare_subscriber(self, key: str, callback: Any) -> Iterator[None]:
        self.subscribed[key] = callback
        yield


@pytest.fixture
def simulator(monkeypatch: pytest.MonkeyPatch) -> Simulator:
    found = Simulator()
    monkeypatch.setattr(link, "query", found.query)
    monkeypatch.setattr(link, "watch_tokens", lambda _session, key, _inbox: found.declare_subscriber(key, None))
    return found


@pytest.fixture
def world(simulator: Simulator) -> WorldQueries:
    return WorldQueries(simulator, KEYS, threading.Event())


def test_parts_of_the_state_are_joined_in_their_order(simulator: Simulator, world: WorldQueries) -> None:
    states = [
        WorldState(run=RUN, tick=2, time=0.1, part=part, parts=2, entity=(one,)) for part, one in ((1, TWO), (0, ONE))
    ]
    simulator.put(KEYS.every_state, *states)
    assert world.entities() == (0.1, [ONE, TWO])


def test_error_reply_of_a_verb_is_its_result(simulator: Simulator, world: WorldQueries) -> None:
    refusal = Result(run=RUN, tick=0, code="incorrect-state", text="why")
    simulator.put(KEYS.ctl("pause"), refusal, ok=False)
    assert world.control("pause", Pause()) == refusal


def test_bodies_of_an_empty_world_are_none(simulator: Simulator, world: WorldQueries) -> None:
    simulator.put(KEYS.every_state, WorldState(run=RUN, tick=0, time=0.0))
    assert world.bodies() == []
    body = Body(run=RUN, tick=0, robot=robot("crate"))
    simulator.put(KEYS.every_state, WorldState(run=RUN, tick=0, time=0.0, entity=(ONE,)))
    simulator.put(KEYS.every_body, body)
    assert world.bodies() == [body]
    simulator.put(KEYS.body("a"), body)
    assert world.body("a") == body


@pytest.mark.parametrize("data", [b"", b"{}", b'{"Run": 5}', b"\xff"])
def test_answer_that_cannot_be_read_is_no_answer(simulator: Simulator, world: WorldQueries, data: bytes) -> None:
    simulator.answers[KEYS.clock] = [link.Answer(KEYS.clock, data, "application/json", True)]
    with pytest.raises(ConnectionError, match="expected a Clock"):
        world.clock()
    simulator.answers[KEYS.clock] = [link.Answer("", b"no", "application/json", False)]
    with pytest.raises(ConnectionError, match="expected an answer, got an error"):
        world.clock()


class Node:
    """Keeps what is published, and stops the gateway after some messages."""

    def __init__(self, stop: threading.Event, count: int) -> None:
        self.sent: list[tuple[str, Any]] = []
        self._stop = stop
        self._count = count

    def advertise(self, topics: Any) -> None:
        assert [topic.name for topic in topics] == ["/clock", "/map"]

    def publish(self, topic: str, message: Any) -> None:
        self.sent.append((topic, message))
        if len(self.sent) == self._count:
            self._stop.set()


def test_map_and_clock_are_published(simulator: Simulator, world: WorldQueries) -> None:
    simulator.put(KEYS.map, floor("room"))
    stop, log = threading.Event(), list[str]()
    node = Node(stop, 2)
    topics = WorldTopics(simulator, KEYS, world, node, resolution=None, log=log.append)
    clock = Clock(run=RUN, tick=3, time=0.15, state="running", pace="realtime", hash=RUN, stamp=0.0)
    topics._take_clock(Put(KEYS.clock, encode(clock), "application/json"))
    topics._take_clock(Put(KEYS.clock, b"{", "application/json"))
    topics.run(stop)
    assert set(simulator.subscribed) == {KEYS.clock, KEYS.map, KEYS.alive}
    assert [topic for topic, _ in node.sent] == ["/clock", "/map"]
    assert node.sent[1][1].info.width == 284
    assert log[0].startswith("dropped key=iw/v1/w/clock")
    assert log[1] == "published topic=/map name=room resolution=0.05"


def test_without_a_simulator_the_map_is_asked_for_again(simulator: Simulator, world: WorldQueries) -> None:
    node = Node(threading.Event(), 1)
    log: list[str] = []
    topics = WorldTopics(simulator, KEYS, world, node, resolution=0.1, log=log.append)
    for _ in range(3):
        topics._publish_map()
    assert node.sent == []
    assert log == [f"waiting why='no simulator at {KEYS.map}, or not allowed'"]
    simulator.put(KEYS.map, floor("room"))
    topics._publish_map()
    assert node.sent[0][1].info.resolution == 0.1


def test_too_fine_a_map_is_made_coarser(simulator: Simulator, world: WorldQueries) -> None:
    simulator.put(KEYS.map, floor("ward"))
    log: list[str] = []
    node = Node(threading.Event(), 1)
    WorldTopics(simulator, KEYS, world, node, resolution=0.001, log=log.append)._publish_map()
    assert node.sent[0][1].info.resolution == 0.05
    assert "--resolution: expected at most 50000000 cells of /map, got" in log[0]
