"""An elastic run can be resimulated from its log alone, to the same hashes."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from intellwheels_experiments.testing.rig import Rig
from tests.e2e.stage import run


def test_elastic_run_with_an_agent_that_was_killed_and_came_back_is_resimulated_to_the_same_hashes(
    intellwheels: Callable[..., Rig], tmp_path: Path
) -> None:
    log = tmp_path / "run.log"
    sim = intellwheels(floor="room", miss="elastic", arguments=("--deadline", "0.3", "--log", str(log)))
    for name in ("chair1", "chair2"):
        sim.agent(name, "drive", robot="rear-wheel", left=0.1, right=0.12, MotorNoise=0.015)
    sim.run_for(2.5)
    sim.kill("chair1")
    sim.run_until(lambda now: now.happened("lost", "chair1"))
    sim.run_for(1.0)
    sim.agent("chair1", "drive", robot="rear-wheel", left=0.1, right=0.12, MotorNoise=0.015)
    sim.run_for(5.0)
    assert sim.end_simulator() == 0

    done = run("intellwheels_server", "--resimulate", str(log))
    assert done.returncode == 0, done.stdout + done.stderr

    # With one wrong hash, the error names its tick.
    lines = log.read_text().splitlines()
    tick = next(i for i, line in enumerate(lines) if i > 30 and "Hash" in json.loads(line))
    entry = json.loads(lines[tick])
    entry["Hash"] = "0" * 16
    lines[tick] = json.dumps(entry)
    log.write_text("\n".join(lines) + "\n")
    done = run("intellwheels_server", "--resimulate", str(log))
    assert done.returncode == 1
    assert str(entry["Tick"]) in done.stdout + done.stderr
