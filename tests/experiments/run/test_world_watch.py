"""A watch sees what a simulator publishes, asks for what it missed, and outlives whatever else is said."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_experiments.run.world_watch import WorldWatch, watching
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.link import Link
from intellwheels_schemas.messages import Pause, Result
from tests.viewer.wire import RUN, Simulator, clock, entity, event, simulator, state, until

pytestmark = pytest.mark.process


@pytest.fixture
def world() -> Iterator[tuple[Simulator, str]]:
    with simulator("watched") as found:
        yield found


@pytest.fixture
def told(world: tuple[Simulator, str]) -> Simulator:
    return world[0]


@pytest.fixture
def link(world: tuple[Simulator, str]) -> Link:
    return Link("watched", connect=(world[1],))


def test_what_is_published_is_in_the_record(told: Simulator, link: Link) -> None:
    record = RunRecord()
    with watching(link, threading.Event()) as watch:

        def seen() -> bool:
            # Published again: a subscription takes a moment to be known.
            told.run(7, entity("a", 1.0, 2.0))
            told.put(told.keys.event, event(0, "joined", agent="a"))
            watch.pour(record)
            return bool(record.clock and record.tracks and record.events)

        until(seen)
    assert record.clock is not None
    assert (record.run, record.clock.tick) == (RUN, 7)
    assert record.positions() == {"a": (1.0, 2.0)}
    assert record.counts == {"joined": 1}


def test_what_cannot_be_read_is_nobodys(told: Simulator, link: Link) -> None:
    record = RunRecord()
    with watching(link, threading.Event()) as watch:

        def seen() -> bool:
            for key in (told.keys.clock, told.keys.event, told.keys.state(0)):
                told.put(key, b"\xff nonsense")
            told.put(told.keys.clock, clock(3))
            watch.pour(record)
            return record.clock is not None

        until(seen)
    assert (record.tracks, record.events) == ({}, {})


def test_events_that_were_missed_and_the_newest_state_are_asked_for(told: Simulator, link: Link) -> None:
    record = RunRecord()
    record.on_event(event(0))
    told.events = [event(number, tick=number) for number in range(3)]
    told.states = [state(9, entity("a", 4.0, 5.0))]
    told.clock = clock(9)
    with watching(link, threading.Event(), listens=False) as watch:
        watch.complete(record)
    assert sorted(record.events) == [0, 1, 2]
    assert any(selector.endswith("event?since=1") for selector in told.fetched)
    assert record.positions() == {"a": (4.0, 5.0)}
    assert record.clock == told.clock


def test_a_verb_is_asked_and_its_answer_returned(told: Simulator, link: Link) -> None:
    told.verdict = lambda verb, _data: Result(code="ok", text=verb)
    with watching(link, threading.Event(), listens=False) as watch:
        assert watch.control("pause", Pause()).text == "pause"
        told.verdict = lambda _verb, _data: b"no result"
        with pytest.raises(WireError):
            watch.control("pause", Pause())


def test_a_simulator_that_does_not_answer_leaves_the_record_as_it_was(
    told: Simulator, link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    record = RunRecord()
    with watching(link, threading.Event(), listens=False) as watch:
        monkeypatch.setattr("intellwheels_experiments.run.world_watch.ANSWER_LIMIT", 0.1)
        told.verdict = lambda _verb, _data: None
        with pytest.raises(ConnectionError):
            watch.control("pause", Pause(), timeout=0.1)
        told.close()
        told._held.clear()
        watch.look(record)
    assert (record.run, record.tracks) == (None, {})


def test_a_watch_that_is_told_to_stop_does_not_begin() -> None:
    stop = threading.Event()
    stop.set()
    with (
        pytest.raises(ConnectionError, match=r"told to stop before .* answered"),
        watching(Link("watched", connect=("tcp/127.0.0.1:1",)), stop),
    ):
        pytest.fail("there is nobody to watch")


def test_a_closed_watch_hears_nothing_further(told: Simulator, link: Link) -> None:
    record = RunRecord()
    with watching(link, threading.Event()) as watch:
        assert isinstance(watch, WorldWatch)

        def seen() -> bool:
            told.run(1, entity("a"))
            watch.pour(record)
            return record.clock is not None

        until(seen)
    told.run(2, entity("a"))
    watch.pour(record)
    assert record.clock is not None
    assert record.clock.tick == 1
