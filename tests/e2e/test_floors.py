"""A building of another program runs as processes: each leaf of its doors is an agent."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.e2e.stage import run
from tests.maps.importers.drawn_floors import drawn, write_rmf, write_ros

pytestmark = pytest.mark.process


def test_a_building_runs_with_its_doors(tmp_path: Path) -> None:
    floor = drawn(4)
    ((name, data),) = write_rmf(floor).items()
    (tmp_path / name).write_bytes(data)
    result = tmp_path / "result.json"
    words = ["--floor", f"{tmp_path / name}#L1", "--doors", "--json", str(result), "--logs", str(tmp_path / "logs")]
    done = run("intellwheels_experiments", *words, timeout=180.0)
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads(result.read_text())
    assert found["held"] is True
    assert len(found["agents"]) == len(floor.doors)


def test_a_floor_runs_to_its_end_without_agents(tmp_path: Path) -> None:
    files = write_ros(drawn(2))
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    words = ["--floor", str(tmp_path / next(iter(files))), "--logs", str(tmp_path / "logs")]
    done = run("intellwheels_experiments", *words, timeout=120.0)
    assert done.returncode == 0, done.stdout + done.stderr
