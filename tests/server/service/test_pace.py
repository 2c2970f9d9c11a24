from __future__ import annotations

import pytest

from intellwheels_server.service.pace import (
    BACKLOG,
    MANY_LATE,
    WATCHED,
    BusyShare,
    LateWatch,
    Metronome,
    RealTimeFactor,
)


def test_lateness_does_not_add_up() -> None:
    metronome = Metronome(0.05, 1.0)
    metronome.start(10.0)
    for tick in range(1, 101):
        metronome.begin_tick(metronome.due() + 0.004)
        assert metronome.due() == pytest.approx(10.0 + 0.05 * (tick + 1))
    assert metronome.late == 0


def test_tick_that_begins_late_by_more_than_a_tenth_is_counted() -> None:
    metronome = Metronome(0.05, 1.0)
    metronome.start(0.0)
    assert not metronome.begin_tick(0.0549)
    assert metronome.late == 0
    assert metronome.begin_tick(0.1 + 0.0051)
    assert metronome.late == 1


def test_lateness_is_told_once_when_it_begins_and_once_when_it_is_over() -> None:
    watch = LateWatch()
    assert [watch.add(True) for _ in range(MANY_LATE - 1)] == [None] * (MANY_LATE - 1)
    assert [watch.add(False) for _ in range(WATCHED)] == [None] * WATCHED, "a few late ticks are no trouble"
    found = [watch.add(True) for _ in range(2 * WATCHED)]
    assert found == [None] * (MANY_LATE - 1) + ["late"] + [None] * (2 * WATCHED - MANY_LATE)
    assert [watch.add(False) for _ in range(2 * WATCHED)] == [None] * (WATCHED - 1) + ["on time"] + [None] * WATCHED


def test_speed_divides_the_interval() -> None:
    metronome = Metronome(0.05, 4.0)
    metronome.start(0.0)
    assert metronome.due() == pytest.approx(0.0125)
    metronome.change_speed(0.5, 1.0)
    assert metronome.due() == pytest.approx(1.1)


def test_run_that_is_far_behind_drops_the_lost_time() -> None:
    metronome = Metronome(0.05, 1.0)
    metronome.start(0.0)
    metronome.begin_tick(5.0)
    assert metronome.late == 1
    assert metronome.due() == pytest.approx(5.05)


def test_run_that_is_a_little_behind_catches_up() -> None:
    metronome = Metronome(0.05, 1.0)
    metronome.start(0.0)
    metronome.begin_tick(BACKLOG)
    assert metronome.due() == pytest.approx(0.1)


def test_factor_is_recent_simulated_time_over_wall_time() -> None:
    factor = RealTimeFactor(0.05)
    assert factor.value(0.0) == 0.0
    for tick in range(400):
        factor.count_tick(tick * 0.0125)
    assert factor.value(5.0) == pytest.approx(4.0, rel=0.05)


def test_factor_falls_when_no_tick_comes() -> None:
    factor = RealTimeFactor(0.05)
    for tick in range(41):
        factor.count_tick(tick * 0.05)
    assert factor.value(60.0) < 0.1


def test_busy_share_is_that_of_the_last_second() -> None:
    share = BusyShare()
    assert share.value(100.0) == 0.0
    for k in range(1, 11):
        share.spend(0.03, 100.0 + 0.1 * k)
    assert share.value(101.0) == pytest.approx(0.3, rel=0.1)
    for k in range(1, 12):
        share.spend(0.09, 101.0 + 0.1 * k)
    assert share.value(102.1) == pytest.approx(0.9, rel=0.1)
    assert share.value(110.0) < 0.2
