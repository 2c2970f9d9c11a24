from __future__ import annotations

from typing import Any

import pytest

from intellwheels_maps import floor
from intellwheels_schemas.messages import Pace
from intellwheels_server.service.arrival import Query
from intellwheels_server.service.pacing import Pacing, PendingSteps
from intellwheels_server.world import Setup


def pacing_of(pace: Pace = "realtime", speed: float = 1.0, **setup: Any) -> Pacing:
    return Pacing(pace, Setup(floor=floor("room"), **setup), speed=speed, deadline=1.0)


def query() -> Query:
    return Query("ctl", "step", b"", "", lambda *_: None, lambda: None)


def test_run_is_stopped_while_it_waits_is_paused_or_has_ended() -> None:
    pacing = pacing_of()
    assert pacing.is_stopped(ended=False)
    pacing.waiting_to_start = False
    assert not pacing.is_stopped(ended=False)
    assert pacing.is_stopped(ended=True)
    pacing.paused = True
    assert pacing.is_stopped(ended=False)
    pacing.steps = PendingSteps(1, query())
    assert not pacing.is_stopped(ended=False)


@pytest.mark.parametrize(
    ("pace", "speed", "real"), [("realtime", 1.0, True), ("realtime", 2.0, False), ("lockstep", 1.0, False)]
)
def test_only_real_time_at_speed_1_is_real_speed(pace: Pace, speed: float, real: bool) -> None:
    assert pacing_of(pace, speed).at_real_speed is real


def test_new_run_waits_to_start_and_counts_no_late_ticks() -> None:
    pacing = pacing_of("lockstep")
    pacing.waiting_to_start, pacing.barrier_open, pacing.metronome.late = False, True, 3
    pacing.begin_new_run(["chair1"])
    assert (pacing.waiting_to_start, pacing.barrier_open, pacing.metronome.late) == (True, False, 0)
    pacing.barrier.open([("chair1", "actions"), ("chair2", "actions")], 0.0)
    assert pacing.barrier.awaited == ("chair2",)  # the body of chair1 rests


def test_clock_that_starts_sets_the_next_deadline_one_interval_ahead() -> None:
    pacing = pacing_of(period=0.1)
    pacing.start_clock(5.0)
    assert pacing.metronome.due() == pytest.approx(5.1)
