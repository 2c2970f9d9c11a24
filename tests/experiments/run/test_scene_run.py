"""However a run finishes, it has a result. Simulator and agents here are small Python programs."""

from __future__ import annotations

import io
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from intellwheels_experiments.run.child_processes import ChildProcesses
from intellwheels_experiments.run.launch_spec import LaunchSpec
from intellwheels_experiments.run.progress import Progress
from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_experiments.run.run_report import Result as RunResult
from intellwheels_experiments.run.scene_run import perform
from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import (
    Cast,
    End,
    Entity,
    Grid,
    Hold,
    Map,
    Place,
    Reach,
    Record,
    Result,
    Scene,
    WorldState,
)

pytestmark = pytest.mark.process

RUN = "0" * 16
HASH = "00000000000000ff"
FLOOR = Map(format="iw.v1", name="room", grid=Grid(position=(Place(name="goal1", x=5.0, y=1.0),)))
SCENE = Scene(
    format="iw.v1",
    name="test",
    map="room",
    cast=(Cast(name="chair1", robot="rear-wheel", mind="waypoints"),),
    end=End(reach=(Reach(agent="chair1", place="goal1", within=0.3),)),
    hold=Hold(contacts=0, reached="all"),
)

ENDS = "import signal; signal.signal(signal.SIGTERM, lambda *_: exit(0)); "
"""A process of this project ends with exit code 0 when it is told to."""
READY = ENDS + "print('ready world=main', flush=True); "
RUNNING = READY + "print('running tick=0', flush=True); "
WAIT = "import signal; signal.alarm(60); signal.pause()"


@dataclass(frozen=True, kw_only=True)
class FakeSpec(LaunchSpec):
    server: str
    agent: str = WAIT

    def server_command(self, lifeline: int) -> list[str]:
        return [sys.executable, "-c", self.server]

    def viewer_command(self, lifeline: int) -> list[str]:
        return [sys.executable, "-c", READY + WAIT]

    def agent_command(self, cast: Cast, lifeline: int) -> list[str]:
        return [sys.executable, "-c", self.agent]


class FakeWatch:
    def control(self, verb: Verb, message: Record, timeout: float) -> Result:
        raise AssertionError(verb)

    def drain(self, record: RunRecord) -> None:
        pass

    def query_all(self, record: RunRecord) -> None:
        chair = Entity(name="chair1", x=5.0, y=1.0, heading=0.0)
        record.on_state(WorldState(run=RUN, tick=9, time=0.45, entity=(chair,)))


@contextmanager
def watching(stop: threading.Event) -> Iterator[FakeWatch]:
    yield FakeWatch()


@contextmanager
def interrupting(stop: threading.Event) -> Iterator[FakeWatch]:
    """Break the run off as soon as it is watched."""
    stop.set()
    yield FakeWatch()


def spec_of(tmp_path: Path, server: str, agent: str = WAIT, **given: Any) -> FakeSpec:
    return FakeSpec(
        scene=SCENE,
        source="test",
        floor=FLOOR,
        world="main",
        listen=("tcp/127.0.0.1:1",),
        logs=tmp_path,
        server=server,
        agent=agent,
        **given,
    )


def play(tmp_path: Path, server: str, agent: str = WAIT, *, timeout: float = 60.0, stop: bool = False) -> RunResult:
    spec = spec_of(tmp_path, server, agent, timeout=timeout)
    with Progress(Console(file=io.StringIO()), SCENE, FLOOR) as progress:
        return perform(spec, interrupting if stop else watching, progress, threading.Event())


def test_run_that_ends_is_judged_by_the_last_state(tmp_path: Path) -> None:
    result = play(tmp_path, RUNNING + f"print('ended tick=812 hash={HASH}', flush=True); {WAIT}")
    assert (result.finish, result.hash, result.ticks, result.held) == ("ended", HASH, 812, True)
    assert result.time == pytest.approx(40.6)
    assert result.wall > 0.0


def test_simulator_that_fails_or_is_killed_after_the_end_does_not_hold(tmp_path: Path) -> None:
    # The run ends the simulator as soon as it reads the line. Here the simulator must fail by itself, at any speed.
    deaf = "signal.signal(signal.SIGTERM, signal.SIG_IGN); "
    ended = RUNNING + deaf + f"print('ended tick=812 hash={HASH}', flush=True); "
    for last, how in (("exit(1)", "exit 1"), ("import os; os.kill(os.getpid(), 9)", "killed by SIGKILL")):
        result = play(tmp_path, ended + last)
        assert (result.finish, result.held) == ("died", False)
        assert result.words.startswith(f"server: {how}; ")


def test_agent_that_dies_is_named_with_its_last_lines(tmp_path: Path) -> None:
    result = play(tmp_path, RUNNING + WAIT, "raise SystemExit('no such mind')")
    assert result.finish == "died"
    assert result.words.startswith("agent-chair1: exit 1; the last lines of ")
    assert result.words.endswith("  no such mind")
    assert not result.held


def test_agent_that_leaves_is_no_death(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The simulator goes on to its end only after the run was told that the agent has left.
    os.mkfifo(tmp_path / "left")
    left = os.open(tmp_path / "left", os.O_RDWR)
    receive = ChildProcesses.receive

    def received(children: ChildProcesses, timeout: float = 0.0) -> None:
        receive(children, timeout)
        if "agent-chair1" in children.exits:
            os.write(left, b"\n")

    monkeypatch.setattr(ChildProcesses, "receive", received)
    after = f"open({str(tmp_path / 'left')!r}).readline(); "
    server = RUNNING + after + f"print('ended tick=1 hash={HASH}', flush=True); {WAIT}"
    try:
        assert play(tmp_path, server, "pass").finish == "ended"
    finally:
        os.close(left)


def test_simulator_that_dies_before_it_is_ready_is_named(tmp_path: Path) -> None:
    result = play(tmp_path, "raise SystemExit('port taken')")
    assert result.finish == "died"
    assert "server: exit 1" in result.words
    assert result.words.endswith("port taken")


def test_miss_names_who_missed(tmp_path: Path) -> None:
    result = play(tmp_path, RUNNING + f"print('miss agent=chair1 tick=40', flush=True); {WAIT}")
    assert (result.finish, result.ticks, result.held) == ("missed", 40, False)
    assert result.words.startswith("agent-chair1: missed tick 40")


def test_interrupted_run_says_what_happened(tmp_path: Path) -> None:
    result = play(tmp_path, RUNNING + WAIT, stop=True)
    assert result.finish == "interrupted"
    assert result.agents[0].reached is True
    assert not result.held


def test_run_that_takes_too_long_is_aborted(tmp_path: Path) -> None:
    assert play(tmp_path, RUNNING + WAIT, timeout=0.5).finish == "overtime"


class LostWatch(FakeWatch):
    """Loses the simulator once the run has been judged."""

    def __init__(self) -> None:
        self._judged = False

    def drain(self, record: RunRecord) -> None:
        if self._judged:
            raise ConnectionError("the simulator does not answer")

    def query_all(self, record: RunRecord) -> None:
        super().query_all(record)
        self._judged = True


def test_simulator_that_is_lost_behind_the_page_leaves_the_result_as_it_was(tmp_path: Path) -> None:
    said = io.StringIO()
    server = RUNNING + f"print('ended tick=812 hash={HASH}', flush=True); {WAIT}"
    with Progress(Console(file=said), SCENE, FLOOR) as progress:
        result = perform(
            spec_of(tmp_path, server, timeout=60.0, view=0),
            lambda _: nullcontext(LostWatch()),
            progress,
            threading.Event(),
        )
    assert (result.finish, result.held) == ("ended", True)
    assert "the page ends: the simulator does not answer" in said.getvalue()
