"""The process `iw-record`: what it waits for. `tests/e2e/test_record.py` has whole recordings."""

from __future__ import annotations

from pathlib import Path

import pytest

from intellwheels_schemas.link import START_ONE
from tests.e2e.stage import run

pytestmark = pytest.mark.process


def test_without_a_router_it_gives_up_in_time(tmp_path: Path) -> None:
    words = (str(tmp_path / "run.mcap"), "--connect", "tcp/127.0.0.1:1", "--retry-for", "0.5")
    done = run("intellwheels_agents.record_gateway", *words)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.splitlines() == [
        f"iw-record: waiting why='nobody answers at tcp/127.0.0.1:1; {START_ONE}'",
        "iw-record: nobody answers at tcp/127.0.0.1:1",
    ]
