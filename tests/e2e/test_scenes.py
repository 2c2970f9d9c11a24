"""The other scenes as processes: the conditions of each scene hold."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.e2e.stage import run


@pytest.mark.parametrize("scene", ["follow", "door", "corner", "crossing", "feelings"])
def test_conditions_of_the_scene_hold(tmp_path: Path, scene: str) -> None:
    file = tmp_path / "result.json"
    done = run("intellwheels_experiments", scene, "--json", str(file), "--logs", str(tmp_path / "logs"), timeout=180.0)
    assert done.returncode == 0, done.stdout + done.stderr
    result = json.loads(file.read_text())
    assert result["held"] is True
    assert result["contacts"] == 0


def test_changed_mind_and_options_count_in_a_single_run(tmp_path: Path) -> None:
    results = []
    for change in ((), ("--mind", "chair=drive", "--option", "chair.left=0.4", "--option", "chair.right=0.4")):
        file = tmp_path / f"result{len(change)}.json"
        done = run("intellwheels_experiments", "door", "--json", str(file), *change, timeout=180.0)
        assert done.returncode == 0, done.stdout + done.stderr
        results.append(json.loads(file.read_text()))
    assert results[1]["ticks"] > 1.1 * results[0]["ticks"]


@pytest.mark.parametrize("limit", [20, pytest.param(60, marks=pytest.mark.soak), 100])
def test_log_that_cannot_be_written_to_its_end_fails_the_run(tmp_path: Path, limit: int) -> None:
    """A quota: no file of the run may have more than so many blocks of 1,024 bytes."""
    log = tmp_path / "run.jsonl"
    words = [sys.executable, "-m", "intellwheels_experiments", "door", "--log", str(log), "--logs", str(tmp_path / "l")]
    command = ["bash", "-c", f'ulimit -f {limit}; exec "$@"', "bash", *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=180.0, check=False)
    assert done.returncode == 1, done.stdout + done.stderr
    assert "File too large" in done.stdout + done.stderr
    assert str(log) in (done.stdout + done.stderr).replace("\n", "")


def test_log_on_a_full_disk_fails_the_run(tmp_path: Path) -> None:
    done = run(
        "intellwheels_experiments", "door", "--log", "/dev/full", "--logs", str(tmp_path / "logs"), timeout=180.0
    )
    assert done.returncode == 1
    assert "--log /dev/full: No space left on device" in done.stdout + done.stderr
