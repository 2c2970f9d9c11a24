"""Moments are whole, in order, and of one run."""

from __future__ import annotations

import math

import pytest

from intellwheels_experiments.film import AbsentError, Film, Moment, Point
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


def newest(film: Film) -> Moment:
    assert film.newest is not None
    return film.newest


def test_path_has_a_point_for_each_tick_and_the_later_of_equals() -> None:
    film = Film()
    for tick, x in ((0, 1.0), (1, 2.0), (1, 2.5), (2, 3.0)):
        film.on_state(state(tick, x))
    assert film.paths["chair1"] == [Point(0.0, 1.0, 1.0, 0.5), Point(0.5, 2.5, 1.0, 0.5), Point(1.0, 3.0, 1.0, 0.5)]


def test_state_that_is_older_is_no_moment() -> None:
    film = Film()
    film.on_state(state(5, 1.0))
    film.on_state(state(4, 9.0))
    assert [moment.tick for moment in film.fresh] == [5]


def test_moment_needs_all_parts_of_one_tick() -> None:
    film = Film()
    film.on_state(state(1, name="a", part=0, parts=2))
    film.on_state(state(2, name="b", part=1, parts=2))
    assert film.newest is None
    film.on_state(state(2, name="a", part=0, parts=2))
    assert (newest(film).tick, list(newest(film).bodies)) == (2, ["a", "b"])


def test_parts_that_become_fewer_within_a_tick_are_not_mixed() -> None:
    film = Film()
    film.on_state(state(2, name="b", part=1, parts=2))
    film.on_state(state(2, name="a"))
    assert list(newest(film).bodies) == ["a"]


def test_new_run_begins_with_nothing_of_the_last() -> None:
    film = Film()
    film.on_event(event(0))
    film.on_state(state(900, 5.0))
    film.on_event(event(0, "reset", NEXT_RUN))
    film.on_state(state(0, 1.0, run=NEXT_RUN))
    assert newest(film).tick == 0
    assert [each.code for each in newest(film).events] == ["reset"]
    assert film.paths["chair1"] == [Point(0.0, 1.0, 1.0, 0.5)]
    film.on_state(state(901, 9.0))
    assert newest(film).tick == 0


def test_moment_has_the_events_until_then_in_order() -> None:
    film = Film()
    film.on_events(
        Events(run=RUN, oldest=0, next=2, event=(event(1, "contact", agent="chair1", other="wall"), event(0)))
    )
    film.on_state(state(1))
    before = newest(film)
    film.on_event(event(2, "left", agent="chair1"))
    film.on_state(state(2))
    assert [each.number for each in before.events] == [0, 1]
    assert before.contacts == [("chair1", "wall")]
    assert not before.happened("left")
    assert newest(film).happened("left", "chair1")
    assert not newest(film).happened("left", "chair2")


def test_body_that_is_not_there_is_named_with_those_that_are() -> None:
    film = Film()
    film.on_state(state(3))
    assert newest(film)["chair1"].y == 1.0
    with pytest.raises(AbsentError, match=r"tick 3: expected a body that is there \(chair1\), got 'chair9'"):
        newest(film)["chair9"]


def test_description_says_where_all_are_and_what_happened() -> None:
    film = Film()
    film.on_event(event(0, "contact", agent="chair1", other="wall"))
    film.on_state(state(2, 1.25))
    words = newest(film).describe()
    assert "tick 2, 1.00 s" in words
    assert f"chair1: x 1.250 y 1.000 heading {math.degrees(0.5):.1f} deg" in words
    assert "event: tick 0 contact chair1 wall" in words
