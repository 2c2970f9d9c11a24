from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from intellwheels_server.log.input_log import LogError
from intellwheels_server.log.true_trace import trace_lines
from tests.server.log.test_branch import written
from tests.server.log_edits import records, rewrite


def test_trace_of_a_log_has_every_tick_and_its_hash(tmp_path: Path) -> None:
    hashes = written(tmp_path / "log")
    first, *rest = [msgspec.json.decode(line) for line in trace_lines(tmp_path / "log")]
    assert (first["Trace"], first["Version"], first["Seed"], first["Period"]) == ("iw.v1", 1, "7", 0.05)
    assert [(line["Tick"], line["Hash"]) for line in rest] == list(enumerate(hashes, start=1))
    assert rest[-1]["Body"]["one"]["Power"][0] > 0.0


def test_log_whose_hashes_differ_has_no_trace(tmp_path: Path) -> None:
    hashes = written(tmp_path / "log")
    lines = records(tmp_path / "log")
    rewrite(tmp_path / "log", [line.replace(hashes[3].encode(), b"0" * 16) for line in lines])
    with pytest.raises(LogError, match="expected hash 0000000000000000"):
        list(trace_lines(tmp_path / "log"))
