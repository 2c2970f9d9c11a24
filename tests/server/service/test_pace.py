from __future__ import annotations

import pytest

from intellwheels_server.service.pace import BACKLOG, Metronome, Tachometer


def test_deadlines_are_absolute_so_lateness_does_not_add_up() -> None:
    metronome = Metronome(0.05, 1.0)
    metronome.start(10.0)
    for tick in range(1, 101):
        metronome.began(metronome.due() + 0.004)
        assert metronome.due() == pytest.approx(10.0 + 0.05 * (tick + 1))
    assert metronome.late == 0


def test_a_tick_that_begins_more_than_a_tenth_of_its_time_late_is_counted() -> None:
    metronome = Metronome(0.05, 1.0)
    metronome.start(0.0)
    metronome.began(0.0549)
    assert metronome.late == 0
    metronome.began(0.1 + 0.0051)
    assert metronome.late == 1


def test_speed_divides_the_interval() -> None:
    metronome = Metronome(0.05, 4.0)
    metronome.start(0.0)
    assert metronome.due() == pytest.approx(0.0125)
    metronome.change_speed(0.5, 1.0)
    assert metronome.due() == pytest.approx(1.1)


def test_a_run_that_fell_far_behind_gives_lost_time_up() -> None:
    metronome = Metronome(0.05, 1.0)
    metronome.start(0.0)
    metronome.began(5.0)
    assert metronome.late == 1
    assert metronome.due() == pytest.approx(5.05)


def test_a_run_that_is_a_little_behind_catches_up() -> None:
    metronome = Metronome(0.05, 1.0)
    metronome.start(0.0)
    metronome.began(BACKLOG)
    assert metronome.due() == pytest.approx(0.1)


def test_the_factor_is_simulated_over_wall_time_of_late() -> None:
    tachometer = Tachometer(0.05)
    assert tachometer.factor(0.0) == 0.0
    for tick in range(400):
        tachometer.ticked(tick * 0.0125)
    assert tachometer.factor(5.0) == pytest.approx(4.0, rel=0.05)


def test_the_factor_falls_when_no_tick_comes() -> None:
    tachometer = Tachometer(0.05)
    for tick in range(41):
        tachometer.ticked(tick * 0.05)
    assert tachometer.factor(60.0) < 0.1
