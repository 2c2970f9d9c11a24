"""The time of a recording, and the ticks that it misses."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from intellwheels_agents.record_gateway.run_times import LATEST, RunTimes, Ticks
from intellwheels_schemas.messages import WorldState

RUN, NEXT = "0123456789abcdef", "fedcba9876543210"


def state(tick: int, part: int = 0, parts: int = 1, run: str = RUN) -> WorldState:
    return WorldState(run=run, tick=tick, time=tick * 0.05, part=part, parts=parts)


def test_simulated_time_counts_from_the_time_of_day_at_which_a_run_is_met() -> None:
    times = RunTimes()
    times.begin(RUN, 2.0, 1000.0)
    assert times.at(2.0) == 1000 * 10**9
    assert times.at(3.5) == 1001_500_000_000


def test_a_run_never_begins_before_the_end_of_the_one_before() -> None:
    times = RunTimes()
    times.begin(RUN, 0.0, 0.0)
    end = times.at(60.0)
    times.begin(NEXT, 0.0, 0.0)
    assert times.at(0.0) == end + 1


def test_a_tick_has_a_time_once_the_period_is_known() -> None:
    times = RunTimes()
    times.begin(RUN, 0.0, 0.0)
    assert times.at_tick(20) == times.now == 0
    times.learn_period(10, 0.5)
    assert times.at_tick(20) == 10**9


@given(st.lists(st.floats(0.0, 1e9), min_size=1), st.floats(0.0, 1e12))
def test_no_time_is_later_than_a_message_can_carry(seconds: list[float], unix_time: float) -> None:
    times = RunTimes()
    for number, one in enumerate(seconds):
        times.begin(f"{number:016x}", 0.0, unix_time)
        assert 0 <= times.at(one) <= LATEST


def test_missed_ticks_are_counted_in_each_run() -> None:
    ticks = Ticks()
    for tick in (3, 4, 7):
        assert ticks.add(state(tick)) == (state(tick),)
    assert ticks.add(state(7)) == ticks.add(state(2)) == ()
    ticks.add(state(0, run=NEXT))
    ticks.add(state(2, run=NEXT))
    assert (ticks.seen, ticks.missed) == (5, 3)


def test_a_state_counts_when_all_of_its_parts_are_there() -> None:
    ticks = Ticks()
    assert ticks.add(state(1, 1, 2)) == ()
    assert ticks.add(state(1, 5, 2)) == ()
    assert [one.part for one in ticks.add(state(1, 0, 2))] == [0, 1]
    assert ticks.add(state(2, 0, 2)) == ()
    assert ticks.add(state(3)) == (state(3),)
    assert (ticks.seen, ticks.missed) == (2, 1)
