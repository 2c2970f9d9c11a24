"""A log that is played: what is no log is refused. `tests/e2e/test_record.py` records one."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.e2e.stage import run

pytestmark = pytest.mark.process


def test_what_is_no_log_is_refused_with_its_place(tmp_path: Path) -> None:
    log = tmp_path / "run.jsonl"
    log.write_text("no log\n")
    done = run("intellwheels_agents.record_gateway", str(tmp_path / "x.mcap"), "--from", str(log))
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("iw-record: ")
    assert str(log) in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "x.mcap").exists()
