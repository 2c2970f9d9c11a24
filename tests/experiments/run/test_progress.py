"""The progress line says how far a run is."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from intellwheels_experiments.run.progress import Progress, describe
from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_schemas.messages import Clock, Entity, Map, Scene, WorldState

RUN = "0" * 16
GOALS = {"chair1": (5.0, 1.0, 0.3), "chair2": (0.0, 0.0, 0.3)}


def record(waiting: tuple[str, ...] = ()) -> RunRecord:
    seen = RunRecord()
    seen.on_clock(
        Clock(
            run=RUN, tick=40, time=2.0, state="running", pace="lockstep", factor=12.0, hash=RUN, stamp=1.0,
            waiting=waiting,
        )
    )  # fmt: skip
    chairs = (Entity(name="chair1", x=3.0, y=1.0, heading=0.0), Entity(name="chair2", x=0.1, y=0.0, heading=0.0))
    seen.on_state(WorldState(run=RUN, tick=40, time=2.0, entity=chairs))
    return seen


def test_line_has_time_factor_and_remaining_distances() -> None:
    assert describe(record(), GOALS) == "running 2.0 s, 12.0 times real time; chair1 2.0 m to go, chair2 at its goal"


def test_line_names_agents_that_are_awaited() -> None:
    assert "; waiting for chair1, chair2; chair1 2.0 m to go" in describe(record(("chair1", "chair2")), GOALS)


def test_line_before_the_first_message_says_so() -> None:
    assert describe(RunRecord(), GOALS) == "nothing received yet"


def test_nothing_is_printed_before_the_first_message(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("intellwheels_experiments.run.progress.PLAIN_EVERY", 0.0)
    text = io.StringIO()
    scene, floor = Scene(format="iw.v1", name="test", map="room"), Map(format="iw.v1", name="room")
    with Progress(Console(file=text), scene, floor) as progress:
        progress.follow(RunRecord())
        assert text.getvalue() == ""
        progress.follow(record())
    assert text.getvalue().startswith("progress running 2.0 s")


def test_line_that_says_nothing_new_is_not_printed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("intellwheels_experiments.run.progress.PLAIN_EVERY", 0.0)
    text = io.StringIO()
    scene, floor = Scene(format="iw.v1", name="test", map="room"), Map(format="iw.v1", name="room")
    with Progress(Console(file=text), scene, floor) as progress:
        for waiting in ((), (), ("chair1",), ("chair1",), ()):
            progress.follow(record(waiting))
    assert ["waiting for" in line for line in text.getvalue().splitlines()] == [False, True, False]


def test_words_are_not_taken_for_markup() -> None:
    text = io.StringIO()
    scene, floor = Scene(format="iw.v1", name="test", map="room"), Map(format="iw.v1", name="room")
    with Progress(Console(file=text), scene, floor) as progress:
        progress.say("[bold]logs=/tmp/[x]")
        progress.follow(record())
    assert text.getvalue() == "[bold]logs=/tmp/[x]\n"
