"""The record of a run does not depend on the order in which messages arrive."""

from __future__ import annotations

import math

import msgspec
import pytest

from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_schemas.messages import Clock, Entity, Event, Events, WorldState

RUN = "0" * 15 + "1"
NEXT_RUN = "0" * 15 + "2"


def state(tick: int, x: float, heading: float = 0.0, run: str = RUN) -> WorldState:
    return WorldState(
        run=run, tick=tick, time=tick * 0.05, entity=(Entity(name="chair1", x=x, y=0.0, heading=heading),)
    )


def clock(tick: int, stamp: float = 1.0, run: str = RUN) -> Clock:
    return Clock(run=run, tick=tick, time=tick * 0.05, state="running", pace="lockstep", hash="0" * 16, stamp=stamp)


def event(number: int, code: str = "joined") -> Event:
    return Event(run=RUN, tick=number, number=number, code=code)  # type: ignore[arg-type]


def test_path_is_the_sum_of_what_was_seen() -> None:
    record = RunRecord()
    for tick, x in enumerate((0.0, 1.0, 0.5)):
        record.on_state(state(tick, x))
    assert record.tracks["chair1"].length == 1.5


def test_path_and_turn_are_those_of_the_simulator_whatever_was_seen() -> None:
    sums = ((0.5, 0.25), (3.0, 1.5), (3.5, 1.5))
    states = [
        msgspec.structs.replace(shown, entity=(msgspec.structs.replace(shown.entity[0], travelled=way, turned=angle),))
        for tick, (way, angle) in enumerate(sums)
        for shown in (state(tick, 0.1 * tick),)
    ]
    for seen in (states, states[::2], states[2:], states[::-1]):
        record = RunRecord()
        for each in seen:
            record.on_state(each)
        assert (record.tracks["chair1"].length, record.tracks["chair1"].turned) == (3.5, 1.5)


def test_state_that_is_older_changes_nothing() -> None:
    record = RunRecord()
    record.on_state(state(5, 1.0))
    record.on_state(state(4, 9.0))
    assert record.positions() == {"chair1": (1.0, 0.0)}
    assert record.tracks["chair1"].length == 0.0


def test_turn_is_the_largest_angle_in_either_direction() -> None:
    record = RunRecord()
    for tick, degrees in enumerate((170, -170, 175, 171)):
        record.on_state(state(tick, 0.0, math.radians(degrees)))
    assert record.tracks["chair1"].turned == pytest.approx(math.radians(20))


def test_new_run_clears_the_record_and_the_old_run_does_not_return() -> None:
    record = RunRecord()
    record.on_state(state(900, 5.0))
    record.on_event(event(0))
    record.on_state(state(0, 1.0, run=NEXT_RUN))
    record.on_state(state(901, 5.0))
    record.on_event(event(1))
    record.on_clock(clock(901))
    assert record.run == NEXT_RUN
    assert record.positions() == {"chair1": (1.0, 0.0)}
    assert record.events == {}
    assert record.clock is None


def test_event_counts_once_and_a_gap_is_wanted_until_it_is_filled() -> None:
    record = RunRecord()
    for number in (0, 2, 2, 0):
        record.on_event(event(number))
    assert record.counts == {"joined": 2}
    assert record.next_missing == 1
    record.on_events(Events(run=RUN, oldest=0, next=4, event=(event(1), event(3, "contact"))))
    assert record.next_missing == 4
    assert record.counts == {"joined": 3, "contact": 1}


def test_event_that_ended_the_run_is_recorded() -> None:
    record = RunRecord()
    record.on_event(event(0, "ended"))
    assert record.ended == event(0, "ended")


def test_later_clock_of_one_tick_counts() -> None:
    record = RunRecord()
    record.on_clock(clock(3, stamp=2.0))
    record.on_clock(clock(3, stamp=1.0))
    record.on_clock(clock(2, stamp=9.0))
    assert record.clock == clock(3, stamp=2.0)
