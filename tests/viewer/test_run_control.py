"""Pause, resume, run again and play, by what the run is doing."""

from __future__ import annotations

from dataclasses import replace

import pytest

from intellwheels_schemas.messages import Pause, Record, Reset, Resume, Seek
from intellwheels_viewer.run_control import RunControl, step_hint
from intellwheels_viewer.snapshot import Snapshot
from tests.every_case import every_case
from tests.viewer.opened import SNAPSHOT, Network
from tests.viewer.panels.made_up import clock
from tests.viewer.steering_queue import requests_of
from tests.viewer.wire import RUN, event, until

LOG = replace(SNAPSHOT, last_tick=3400, tick=100)


def sent(call: str, snapshot: Snapshot, count: int = 1) -> list[Record]:
    network = Network()
    with requests_of(network) as requests:
        getattr(RunControl(requests), call)(snapshot)
        until(lambda: len(network.asked) >= count)
    return [message for _, message in network.asked]


@pytest.mark.parametrize(
    ("state", "message"), [("running", Pause()), ("waiting", Pause()), ("paused", Resume()), ("ended", Reset())]
)
def test_the_main_key_does_what_the_state_of_the_run_asks_for(state: str, message: Record) -> None:
    assert sent("toggle", replace(SNAPSHOT, clock=clock(state))) == [message]


def test_the_main_key_pauses_and_plays_a_log() -> None:
    assert sent("toggle", replace(LOG, clock=clock("running"))) == [Pause()]
    assert sent("toggle", replace(LOG, clock=clock("paused"))) == [Resume()]


def test_play_at_the_end_of_a_log_starts_again() -> None:
    at_end = replace(LOG, tick=3400, clock=clock("ended"))
    for call in ("play", "toggle"):
        assert sent(call, at_end, 2) == [Seek(tick=0), Resume()]


@pytest.mark.parametrize(
    ("snapshot", "words"),
    [
        (replace(SNAPSHOT, clock=clock("ended")), "The run is over. Space runs it again"),
        (replace(SNAPSHOT, clock=clock("running")), "Space pauses it"),
        (replace(SNAPSHOT, clock=clock("paused")), None),
        (replace(SNAPSHOT, clock=clock("waiting")), None),
        (replace(SNAPSHOT, clock=None), None),
    ],
)
def test_a_step_that_is_not_possible_has_a_sentence_that_says_what_is(snapshot: Snapshot, words: str | None) -> None:
    hint = step_hint(snapshot)
    assert hint is None if words is None else words in (hint or "")


WAITING = replace(SNAPSHOT, tick=0, clock=clock("paused", tick=0, time=0.0), events=(event(0),), run=RUN)


def started(*snapshots: Snapshot) -> list[Record]:
    network = Network()
    with requests_of(network) as requests:
        control = RunControl(requests)
        for snapshot in snapshots:
            control.start_waiting(snapshot)
    return [message for _, message in network.asked]


def test_a_run_that_waits_for_a_page_is_started_once() -> None:
    assert started(WAITING, WAITING) == [Resume()]
    assert started(replace(WAITING, last_tick=3400, events=())) == [Resume()]


@every_case(
    "snapshot",
    [
        replace(WAITING, clock=clock("waiting", tick=0)),
        replace(WAITING, clock=clock("running", tick=0)),
        replace(WAITING, tick=5),
        replace(WAITING, clock=clock("paused", tick=7)),
        replace(WAITING, phase="silent"),
        replace(WAITING, events=()),
        replace(WAITING, events=(event(0), event(1, "paused"))),
        replace(WAITING, events=(event(0), event(1, "reset"))),
        replace(LOG, clock=clock("paused")),
    ],
)
def test_a_run_that_somebody_paused_or_that_runs_is_left_alone(snapshot: Snapshot) -> None:
    assert started(snapshot) == []
