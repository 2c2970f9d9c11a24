from __future__ import annotations

import pytest

from intellwheels_agents.tick_guard import AHEAD, TickGuard, contradiction
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import Clock, Measures

RUN, OTHER = "a" * 16, "b" * 16
DATA = (b"", Encoding.JSON)


def measures(tick: int, run: str = RUN) -> Measures:
    return Measures(run=run, tick=tick, time=0.0)


def clock(tick: int, run: str = RUN) -> Clock:
    return Clock(run=run, tick=tick, time=0.0, state="running", pace="realtime", hash="0" * 16, stamp=0.0)


@pytest.mark.parametrize(
    ("run", "tick", "counts"), [(RUN, 5, True), (RUN, 5 + AHEAD, True), (RUN, 6 + AHEAD, False), (OTHER, 5, False)]
)
def test_only_the_present_run_and_the_next_ticks_count_at_once(run: str, tick: int, counts: bool) -> None:
    guard = TickGuard()
    guard.begin(RUN, 5)
    assert guard.counts(measures(tick, run), DATA) is counts
    assert guard.asks() is not counts
    assert not guard.asks(), "one query at a time"
    doubted = guard.take_doubted()
    assert (doubted is None) is counts
    assert guard.take_doubted() is None


def test_ticks_that_follow_each_other_are_never_far_ahead() -> None:
    guard = TickGuard()
    guard.begin(RUN, 0)
    assert all(guard.counts(measures(tick), DATA) for tick in range(100))
    assert guard.counts(measures(3), DATA), "an old one is for the caller to judge"
    assert guard.counts(measures(99 + AHEAD), DATA)


def test_clocks_confirm_when_all_of_them_agree() -> None:
    assert contradiction([clock(9)], measures(9 + AHEAD)) == ""
    assert contradiction([], measures(9))
    assert contradiction([clock(9)], measures(10 + AHEAD))
    assert contradiction([clock(9, OTHER)], measures(9))
    assert contradiction([clock(9), clock(9, OTHER)], measures(9))
