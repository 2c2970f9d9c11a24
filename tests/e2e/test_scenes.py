"""The other scenes as processes: the conditions of each scene hold."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.e2e.stage import run


@pytest.mark.parametrize("scene", ["follow", "door", "corner", "crossing"])
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
