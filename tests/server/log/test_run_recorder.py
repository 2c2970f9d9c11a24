from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_maps import floor
from intellwheels_schemas.file_records import Inputs
from intellwheels_server.log.input_log import Log
from intellwheels_server.log.resimulate import resimulate
from intellwheels_server.log.run_files import LOG, RunFiles
from intellwheels_server.log.run_recorder import RunRecorder
from intellwheels_server.world import Setup, advance, begin, digest

RUN = "0123456789abcdef"


def drive(folder: Path, error: Exception | None = None) -> None:
    """Write two ticks into a log of everything and into a folder of runs, and fail then if asked to."""
    setup = Setup(floor=floor("room"))
    state = begin(setup, RUN)
    files = RunFiles(folder / "runs", "main", lambda: state)
    with RunRecorder(Log(folder / "log", setup, RUN), files) as recorder:
        assert recorder.is_wanted
        for tick in range(2):
            state, _ = advance(state, Inputs())
            recorder.write(tick, Inputs(), digest(state), stepped=True)
        recorder.flush_if_due(1e9)
        for path in (folder / "log", folder / "runs" / RUN / LOG):
            assert path.read_bytes().count(b"\n") == 3
        if error is not None:
            raise error


def test_logs_are_closed_in_order(tmp_path: Path) -> None:
    drive(tmp_path)
    for path in (tmp_path / "log", tmp_path / "runs" / RUN / LOG):
        found = resimulate(path)
        assert (found.ticks, found.cut, found.differs) == (2, False, None)


def test_logs_of_a_run_that_failed_have_no_end(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="broken"):
        drive(tmp_path, RuntimeError("broken"))
    for path in (tmp_path / "log", tmp_path / "runs" / RUN / LOG):
        found = resimulate(path)
        assert (found.ticks, found.cut) == (2, True)


def test_nothing_is_written_if_nothing_is_wanted() -> None:
    with RunRecorder(None, None) as recorder:
        assert not recorder.is_wanted
        recorder.write(0, Inputs(), "0" * 16, stepped=True)
        recorder.flush_if_due(1.0)
