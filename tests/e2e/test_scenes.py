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
