"""Moments are complete, in order, and of one run."""

from __future__ import annotations

import math

import pytest

from intellwheels_experiments.testing.history import AbsentError, History, Moment, Point
from intellwheels_schemas.messages import Entity, Event, EventCode, Events, WorldState

RUN = "0" * 15 + "1"
NEXT_RUN = "0" * 15 + "2"


def state(
    tick: int, x: float = 0.0, *, name: str = "chair1", part: int = 0, parts: int = 1, run: str = RUN
) -> WorldState:
    entity = Entity(name=name, x=x, y=1.0, heading=0.5)
    return WorldState(run=run, tick=tick, time=tick * 0.5, part=part, parts=parts, entity=(entity,))


def event(number: int, code: EventCode = "joined", run: str = RUN, **more: str) -> Event:
    return Event(run=run, tick=number, number=number, code=code, **more)  # type: ignore[arg-type]


def newest(history: History) -> Moment:
    assert history.newest is not None
    return history.newest


def test_path_has_a_point_for_each_tick_and_the_later_of_equals() -> None:
    history = History()
    for tick, x in ((0, 1.0), (1, 2.0), (1, 2.5), (2, 3.0)):
        history.on_state(state(tick, x))
    assert history.paths["chair1"] == [Point(0.0, 1.0, 1.0, 0.5), Point(0.5, 2.5, 1.0, 0.5), Point(1.0, 3.0, 1.0, 0.5)]


def test_older_state_gives_no_moment() -> None:
    history = History()
    history.on_state(state(5, 1.0))
    history.on_state(state(4, 9.0))
    assert [moment.tick for moment in history.unread] == [5]


def test_moment_needs_all_parts_of_one_tick() -> None:
    history = History()
    history.on_state(state(1, name="a", part=0, parts=2))
    history.on_state(state(2, name="b", part=1, parts=2))
    assert history.newest is None
    history.on_state(state(2, name="a", part=0, parts=2))
    assert (newest(history).tick, list(newest(history).bodies)) == (2, ["a", "b"])


def test_parts_that_become_fewer_within_a_tick_are_not_mixed() -> None:
    history = History()
    history.on_state(state(2, name="b", part=1, parts=2))
    history.on_state(state(2, name="a"))
    assert list(newest(history).bodies) == ["a"]


def test_new_run_begins_with_nothing_of_the_last() -> None:
    history = History()
    history.on_event(event(0))
    history.on_state(state(900, 5.0))
    history.on_event(event(0, "reset", NEXT_RUN))
    history.on_state(state(0, 1.0, run=NEXT_RUN))
    assert newest(history).tick == 0
    assert [each.code for each in newest(history).events] == ["reset"]
    assert history.paths["chair1"] == [Point(0.0, 1.0, 1.0, 0.5)]
    history.on_state(state(901, 9.0))
    assert newest(history).tick == 0


def test_moment_has_the_events_until_then_in_order() -> None:
    history = History()
    history.on_events(
        Events(run=RUN, oldest=0, next=2, event=(event(1, "contact", agent="chair1", other="wall"), event(0)))
    )
    history.on_state(state(1))
    before = newest(history)
    history.on_event(event(2, "left", agent="chair1"))
    history.on_state(state(2))
    assert [each.number for each in before.events] == [0, 1]
    assert before.contacts == [("chair1", "wall")]
    assert not before.happened("left")
    assert newest(history).happened("left", "chair1")
    assert not newest(history).happened("left", "chair2")


def test_absent_body_is_named_with_those_present() -> None:
    history = History()
    history.on_state(state(3))
    assert newest(history)["chair1"].y == 1.0
    with pytest.raises(AbsentError, match=r"tick 3: expected one of the bodies present \(chair1\), got 'chair9'"):
        newest(history)["chair9"]


def test_description_has_every_body_and_the_last_events() -> None:
    history = History()
    history.on_event(event(0, "contact", agent="chair1", other="wall"))
    history.on_state(state(2, 1.25))
    words = newest(history).describe()
    assert "tick 2, 1.00 s" in words
    assert f"chair1: x 1.250 y 1.000 heading {math.degrees(0.5):.1f} deg" in words
    assert "event: tick 0 contact chair1 wall" in words
