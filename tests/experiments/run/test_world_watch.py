"""A watch receives what a world publishes and queries what it missed. The world is a bare Zenoh session."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import pytest
import zenoh

from intellwheels_experiments.run.endpoints import free_endpoint
from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_experiments.run.world_watch import WorldWatch, watching
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.link import Link, open_session
from intellwheels_schemas.messages import Clock, Entity, Event, Events, Pause, Record, Result, WorldState

pytestmark = pytest.mark.process

RUN = "0" * 16
KEYS = Keys("main")
CLOCK = Clock(run=RUN, tick=9, time=0.45, state="running", pace="lockstep", hash=RUN, stamp=1.0)
STATE = WorldState(run=RUN, tick=9, time=0.45, entity=(Entity(name="chair1", x=5.0, y=1.0, heading=0.0),))
EVENTS = tuple(Event(run=RUN, tick=number, number=number, code="joined", agent="chair1") for number in range(3))
DEADLINE = 20.0


@contextmanager
def world(answers: dict[str, Record]) -> Iterator[tuple[zenoh.Session, Link]]:
    """Open a session that answers queries by key, and yield it with the link to it."""
    endpoint = free_endpoint()
    session = open_session(Link("main", listen=(endpoint,)), threading.Event(), timeout=DEADLINE)
    assert session is not None
    with ExitStack() as stack:
        stack.enter_context(session)
        for key, answer in answers.items():
            payload = encode(answer)

            def reply(query: zenoh.Query, key: str = key, payload: bytes = payload) -> None:
                query.reply(key, payload, encoding=Encoding.JSON.value)

            stack.enter_context(session.declare_queryable(key, reply))
        yield session, Link("main", connect=(endpoint,))


def drain_until(watch: WorldWatch, record: RunRecord, condition: Callable[[], bool], put: Callable[[], None]) -> None:
    """Publish and drain until a condition holds: a subscription takes a moment to reach the publisher."""
    deadline = time.monotonic() + DEADLINE
    arrived = threading.Event()
    while not condition():
        assert time.monotonic() < deadline
        put()
        arrived.wait(0.05)
        watch.drain(record)


def test_published_clock_state_and_events_are_recorded_and_junk_is_not() -> None:
    with world({}) as (session, link), watching(link, threading.Event()) as watch:
        record = RunRecord()

        def put() -> None:
            session.put(KEYS.clock, b"junk", encoding=Encoding.JSON.value)
            for key, message in ((KEYS.clock, CLOCK), (KEYS.state(0), STATE), (KEYS.event, EVENTS[0])):
                session.put(key, encode(message), encoding=Encoding.JSON.value)

        drain_until(watch, record, lambda: bool(record.clock and record.tracks and record.events), put)
        assert record.clock == CLOCK
        assert record.positions() == {"chair1": (5.0, 1.0)}
        assert record.events == {0: EVENTS[0]}


def test_missed_events_state_and_clock_are_queried() -> None:
    events = Events(run=RUN, oldest=0, next=3, event=EVENTS)
    answers: dict[str, Record] = {KEYS.event: events, KEYS.state(0): STATE, KEYS.clock: CLOCK}
    with world(answers) as (_, link), watching(link, threading.Event(), subscribes=False) as watch:
        record = RunRecord()
        watch.query_all(record)
        assert (record.clock, record.next_missing) == (CLOCK, 3)
        assert record.positions() == {"chair1": (5.0, 1.0)}


def test_control_verb_is_answered_or_raises() -> None:
    answers: dict[str, Record] = {KEYS.ctl("pause"): Result(code="ok", run=RUN)}
    with world(answers) as (_, link), watching(link, threading.Event(), subscribes=False) as watch:
        assert watch.control("pause", Pause(), DEADLINE) == Result(code="ok", run=RUN)
        with pytest.raises(ConnectionError):
            watch.control("resume", Pause(), 0.5)


def test_watch_that_is_told_to_stop_does_not_connect() -> None:
    stop = threading.Event()
    stop.set()
    with (
        pytest.raises(ConnectionError, match="stopped before"),
        watching(Link("main", connect=(free_endpoint(),)), stop),
    ):
        pass
