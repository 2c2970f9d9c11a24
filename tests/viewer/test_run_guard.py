from __future__ import annotations

import pytest

from intellwheels_schemas.messages import Clock
from intellwheels_viewer.run_guard import AHEAD, RunGuard

RUN, OTHER = "a" * 16, "b" * 16


def clock(tick: int, run: str = RUN) -> Clock:
    return Clock(run=run, tick=tick, time=0.0, state="running", pace="realtime", hash="0" * 16, stamp=0.0)


def test_nothing_counts_before_the_simulator_has_told_its_run() -> None:
    guard = RunGuard()
    assert not guard.counts(clock(0))
    assert guard.doubts
    guard.confirm(clock(0))
    assert not guard.doubts
    assert guard.counts(clock(1))


@pytest.mark.parametrize("forged", [clock(0, OTHER), clock(2**53 - 1), clock(2**53 - 1, OTHER)])
def test_forged_message_is_dropped_and_the_real_ones_count_on(forged: Clock) -> None:
    guard = RunGuard()
    guard.confirm(clock(5))
    assert not guard.counts(forged)
    assert guard.doubts
    assert guard.counts(clock(6))
    guard.confirm(clock(6))
    assert not guard.counts(forged)


def test_confirmed_run_replaces_the_old_one() -> None:
    guard = RunGuard()
    guard.confirm(clock(500))
    assert not guard.counts(clock(0, OTHER))
    guard.confirm(clock(0, OTHER))
    assert guard.counts(clock(1, OTHER))
    assert not guard.counts(clock(501))


def test_older_ticks_and_those_a_little_ahead_count() -> None:
    guard = RunGuard()
    guard.confirm(clock(500))
    assert guard.counts(clock(3))
    assert guard.counts(clock(500 + AHEAD))
    assert guard.counts(clock(500 + 2 * AHEAD))
    assert not guard.counts(clock(501 + 3 * AHEAD))
