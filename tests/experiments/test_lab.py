from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from intellwheels_experiments.processes import free_port


def test_two_real_and_two_virtual_chairs_are_in_one_floor(tmp_path: Path) -> None:
    words = ["--listen", f"tcp/127.0.0.1:{free_port()}", "--seconds", "3", "--logs", str(tmp_path)]
    done = subprocess.run(
        [sys.executable, "-m", "intellwheels_experiments.lab", *words],
        check=False, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert [line.split()[0] for line in done.stdout.splitlines()] == ["ready", "ended"]
    here, there = (
        [json.loads(line) for line in (tmp_path / f"{world}.jsonl").read_text().splitlines()]
        for world in ("main", "lab")
    )
    joined = {
        change["Agent"]
        for line in here
        for change in line.get("Inputs", {}).get("Changes", [])
        if change["Do"] == "Join"
    }
    assert joined == {"real1", "real2", "virtual1", "virtual2", "table"}
    reported = {agent for line in here for agent in line.get("Inputs", {}).get("Poses", {})}
    assert reported == {"real1", "real2"}
    driven = {agent for line in there for agent in line.get("Inputs", {}).get("Actions", {})}
    assert driven == {"real1", "real2"}
    for line in here[-20:]:
        for pose in line.get("Inputs", {}).get("Poses", {}).values():
            assert any(one["Id"].startswith("real-") for one in pose["Sensors"]["Proximity"])
