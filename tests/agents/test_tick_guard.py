from __future__ import annotations

import pytest

from intellwheels_agents.tick_guard import AHEAD, MOST_DOUBTED, TickGuard, agreed, contradiction
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.messages import Clock, Measures

RUN, OTHER = "a" * 16, "b" * 16
DATA = (b"", Encoding.JSON)


def measures(tick: int, run: str = RUN) -> Measures:
    return Measures(run=run, tick=tick, time=0.0)


def clock(tick: int, run: str = RUN) -> Clock:
    return Clock(run=run, tick=tick, time=0.0, state="running", pace="realtime", hash="0" * 16, stamp=0.0)


def said(*clocks: Clock) -> list[tuple[bytes, Encoding]]:
    return [(encode(clock), Encoding.JSON) for clock in clocks]


@pytest.mark.parametrize(
    ("run", "tick", "counts"), [(RUN, 5, True), (RUN, 6, True), (RUN, 6 + AHEAD, False), (OTHER, 5, False)]
)
def test_only_the_present_run_and_the_next_ticks_count_at_once(run: str, tick: int, counts: bool) -> None:
    guard = TickGuard()
    guard.begin(RUN, 5)
    assert guard.counts(measures(tick, run), DATA) is counts
    assert guard.asks() is not counts
    assert not guard.asks(), "one query at a time"
    now = clock(tick, run)
    assert guard.settle(said(now)) == (now, [] if counts else [DATA], [])
    assert guard.settle(said(now)) == (now, [], [])


@pytest.mark.parametrize("step", range(2, AHEAD + 1))
def test_a_step_over_a_few_ticks_counts_at_once_until_one_was_forged(step: int) -> None:
    guard = TickGuard()
    guard.begin(RUN, 5)
    assert guard.counts(measures(5 + step), DATA)
    assert not guard.asks(), "messages are lost now and then"
    assert guard.counts(measures(6), DATA)
    assert guard.asks(), "they come in order"
    guard.settle(said(clock(6)))
    assert guard.fooled
    # From now on each tick waits for the clock.
    assert not guard.counts(measures(7), DATA)
    assert guard.asks()
    assert guard.settle(said(clock(7)))[1] == [DATA]
    assert not guard.fooled


def test_clock_that_answers_late_makes_nothing_old() -> None:
    guard = TickGuard()
    guard.begin(RUN, 5)
    assert guard.counts(measures(7), DATA)
    assert guard.counts(measures(6), DATA), "a copy"
    assert guard.asks()
    assert all(guard.counts(measures(tick), DATA) for tick in range(8, 20))
    guard.settle(said(clock(7)))
    assert not guard.fooled
    assert guard.counts(measures(20), DATA)
    assert not guard.asks()


def test_what_came_after_the_question_waits_for_the_next_one() -> None:
    guard = TickGuard()
    guard.begin(RUN, 5)
    guard.counts(measures(30), DATA)
    assert guard.asks()
    late = b"late", Encoding.JSON
    guard.counts(measures(33), late)
    assert guard.settle(said(clock(30)))[1:] == ([DATA], [])
    assert guard.asks()
    assert guard.settle(said(clock(33)))[1:] == ([late], [])


def test_ticks_that_follow_each_other_are_never_far_ahead() -> None:
    guard = TickGuard()
    guard.begin(RUN, 0)
    assert all(guard.counts(measures(tick), DATA) for tick in range(100))
    assert guard.counts(measures(3), DATA), "an old one is for the caller to judge"
    assert guard.counts(measures(99 + AHEAD), DATA)


def test_clocks_confirm_when_all_of_them_agree() -> None:
    assert contradiction([clock(9)], measures(9)) == ""
    assert contradiction([], measures(9))
    assert contradiction([clock(9)], measures(10))
    assert contradiction([clock(9, OTHER)], measures(9))
    assert contradiction([clock(9), clock(9, OTHER)], measures(9))


def test_of_those_that_waited_the_clock_tells_the_real_ones_from_the_forged() -> None:
    guard = TickGuard()
    guard.begin(RUN, 0)
    waiting = [measures(30), measures(2**53 - 1), measures(31), measures(31, OTHER)]
    for one in waiting:
        assert not guard.counts(one, (f"{one.run} {one.tick}".encode(), Encoding.JSON))
    assert guard.asks()
    _, confirmed, whys = guard.settle(said(clock(31)))
    assert [data for data, _ in confirmed] == [f"{RUN} 30".encode(), f"{RUN} 31".encode()]
    assert len(whys) == 2


def test_measures_that_wait_are_bounded() -> None:
    guard = TickGuard()
    guard.begin(RUN, 0)
    for tick in range(100, 200):
        guard.counts(measures(tick), DATA)
    _, confirmed, whys = guard.settle([])
    assert (len(confirmed), len(whys)) == (0, MOST_DOUBTED)


def test_clocks_of_one_run_agree_on_the_earliest_tick() -> None:
    assert agreed([clock(9), clock(8)]) == clock(8)
    assert agreed([clock(9), clock(9, OTHER)]) is None
    assert agreed([]) is None


def test_clock_that_cannot_be_read_confirms_nothing() -> None:
    guard = TickGuard()
    guard.begin(RUN, 5)
    guard.counts(measures(50), DATA)
    found, confirmed, whys = guard.settle([(b"{", Encoding.JSON)])
    assert (found, confirmed, len(whys)) == (None, [], 1)
