"""What the logs of a simulator have when it is killed."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from intellwheels_server.log.input_log import LogError, LogReader
from intellwheels_server.log.resimulate import resimulate
from intellwheels_server.log.run_files import LOG, TRACE
from tests.e2e.stage import Stage

pytestmark = pytest.mark.process

PROMISE = 1.0
"""Seconds that a killed simulator may lose."""


def last_tick(log: Path) -> int:
    """Return the last tick that is in a log being written."""
    with log.open("rb") as file:
        return [0, *(line.tick + 1 for line in LogReader(file, str(log)).read_all(file))][-1]


def test_killed_simulator_has_everything_in_its_logs_that_is_older_than_a_second(stage: Stage, tmp_path: Path) -> None:
    """The ticks before a pause get old while nothing else is written."""
    log, runs = tmp_path / "run.jsonl", tmp_path / "runs"
    stage.server("--map", "room", "--log", str(log), "--runs", str(runs))
    with stage.peer() as peer:
        peer.tick(12)
        paused = peer.ctl("pause")
        tick, folder = paused["Tick"], runs / paused["Run"]
        moment = b'{"Tick":%d,' % tick

        def written() -> bool | None:
            is_there = all(last_tick(path) >= tick for path in (log, folder / LOG))
            return (is_there and moment in (folder / TRACE).read_bytes()) or None

        stage.wait(written, f"tick {tick} in the files", 5.0 * PROMISE)
        stage.signal(stage.simulator, signal.SIGKILL)
        assert stage.exit(stage.simulator) == -signal.SIGKILL
    for path in (log, folder / LOG):
        found = resimulate(path)
        assert (found.tick, found.hash, found.cut, found.differs) == (tick, paused["Hash"], True, None)
    data = log.read_bytes()
    log.write_bytes(data.replace(b'"Tick":3', b'"Tick":4', 1))
    with pytest.raises(LogError, match=r"run\.jsonl:\d+: expected checksum"):
        resimulate(log)
