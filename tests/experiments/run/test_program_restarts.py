"""A program that does not follow a new run is started again when one begins, and the run begins once more."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest

from intellwheels_experiments.run.child_processes import ChildProcesses
from intellwheels_experiments.run.program_restarts import ProgramRestarts
from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import Cast, Clock, Event, Record, Result

RUNS = tuple(digit * 16 for digit in "123")


class Said:
    """What was done, in order: by the simulator and by the processes."""

    def __init__(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.done: list[str] = []
        self.record = RunRecord()
        self.text: str | None = None
        with ChildProcesses(tmp_path) as children:
            monkeypatch.setattr(children, "dismiss", self._dismiss)
        self.restarts = ProgramRestarts(children, self._start)
        self.restarts.add(Cast(name="a", command="x", new_run="restart"), self._start(Cast(name="a")))
        self.restarts.add(Cast(name="b", command="x"), "b")
        self.done.clear()

    def _dismiss(self, children: Iterable[str]) -> None:
        self.done.append(f"end {','.join(children)}")

    def _start(self, cast: Cast) -> str:
        self.done.append(f"start {cast.name}")
        return f"agent-{cast.name}.2" if self.done[:-1] else f"agent-{cast.name}"

    def query_all(self, record: RunRecord) -> None:
        record.on_event(Event(run=record.run or "", tick=0, number=0, code="reset", text=self.text))

    def control(self, verb: Verb, message: Record, timeout: float) -> Result:
        self.done.append(verb)
        return Result(code="ok", run=RUNS[2], tick=0, hash="0" * 16)

    def see(self, run: str, *, paused: bool = False) -> bool:
        self.record.on_clock(
            Clock(
                run=run,
                tick=0,
                time=0.0,
                state="paused" if paused else "running",
                pace="lockstep",
                stamp=0.0,
                hash="0" * 16,
            )
        )
        return self.restarts.follow(self.record, self)


@pytest.fixture
def said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Said:
    return Said(tmp_path, monkeypatch)


def test_new_run_begins_once_more_with_programs_that_know_it_only(said: Said) -> None:
    assert not said.see(RUNS[0])
    assert not said.see(RUNS[0])
    assert said.done == []
    assert [said.restarts.child_of(name) for name in "abc"] == ["agent-a", "agent-b", "agent-c"]
    assert said.see(RUNS[1])
    assert said.done == ["pause", "end agent-a", "delete", "reset", "start a", "resume"]
    assert [said.restarts.child_of(name) for name in "abc"] == ["agent-a.2", "agent-b", "agent-c"]
    assert not said.see(RUNS[1])  # its last clock, or no other yet
    assert not said.see(RUNS[2])  # the run that it began itself


def test_paused_run_stays_paused(said: Said) -> None:
    said.see(RUNS[0])
    assert said.see(RUNS[1], paused=True)
    assert said.done[-1] == "start a"


def test_restored_run_goes_on_where_it_is(said: Said) -> None:
    said.text = "restored s1: tick 5 of run 1"
    said.see(RUNS[0])
    assert said.see(RUNS[1])
    assert said.done == ["pause", "end agent-a", "start a", "resume"]
