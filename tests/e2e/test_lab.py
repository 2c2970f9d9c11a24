"""`iw-run lab`: two virtual chairs and two stand-ins for real ones, whose true poses never leave the laboratory.

A quarter of a minute of the scene is run twice with the suite, the whole scene with the mark soak.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest
from msgspec import structs

from intellwheels_experiments.run.child_processes import parse
from intellwheels_maps import scene
from intellwheels_schemas.files import write_file
from intellwheels_schemas.messages import End, Timeout
from tests.e2e.stage import Stage, run

REAL = {"real1", "real2"}
LIMIT = 240.0


def lines_of(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def agents_of(lines: list[dict[str, Any]], what: str) -> set[str]:
    return {agent for line in lines for agent in line.get("Inputs", {}).get(what, {})}


@pytest.mark.parametrize("seconds", [15.0, pytest.param(120.0, marks=pytest.mark.soak)])
def test_two_real_and_two_virtual_chairs_share_a_floor_and_each_run_is_the_same(tmp_path: Path, seconds: float) -> None:
    played = tmp_path / "lab.xml"
    played.write_text(write_file(structs.replace(scene("lab"), end=End(timeout=Timeout(seconds=seconds)))))
    hashes = set()
    for turn in ("first", "again"):
        log, result = tmp_path / f"{turn}.jsonl", tmp_path / f"{turn}.json"
        done = run("intellwheels_experiments", str(played), "--json", str(result), "--log", str(log), timeout=LIMIT)
        assert done.returncode == 0, done.stdout + done.stderr
        hashes.add(json.loads(result.read_text())["hash"])
    assert len(hashes) == 1
    assert json.loads(result.read_text())["ticks"] == seconds * 20
    here, there = lines_of(log), lines_of(log.with_stem("again-lab"))
    joins = [one for line in here for one in line.get("Inputs", {}).get("Changes", []) if one["Do"] == "Join"]
    assert {one["Agent"] for one in joins} == REAL | {"virtual1", "virtual2", "table"}
    assert agents_of(here, "Poses") == REAL
    assert agents_of(there, "Actions") == REAL
    # Their minds get the real sonars beside the virtual ones.
    for line in here[-20:]:
        for pose in line.get("Inputs", {}).get("Poses", {}).values():
            assert any(one["Id"].startswith("real-") for one in pose["Sensors"]["Proximity"])


def test_subscriber_to_everything_in_world_lab_finds_no_truth(tmp_path: Path) -> None:
    logs = tmp_path / "of-the-run"
    command = [sys.executable, "-m", "intellwheels_experiments", "lab", "--pace", "realtime", "--logs", str(logs)]
    with Stage(tmp_path, "lab") as stage:
        stage.launch("run", lambda _lifeline: command)

        def printed() -> str | None:
            lines = (tmp_path / "logs" / "run.log").read_text().splitlines()
            return next((line for line in lines if line.startswith("laboratory ")), None)

        values = parse(stage.wait(printed, "endpoint of the laboratory", LIMIT))[1]
        assert (values["world"], values["chairs"]) == ("lab", "real1,real2")
        stage.endpoint = values["at"]
        with stage.peer() as spy:
            everything = spy.hear("**")
            stage.wait(lambda: True if len(everything) > 200 else None, "200 messages", LIMIT)
            heard = list(everything)
    kinds = {key.removeprefix(spy.prefix) for key, _ in heard}
    assert {"clock", "out/real1/measures", "out/real2/measures", "in/real1/actions", "in/real2/actions"} <= kinds
    assert not any(kind.startswith("state") for kind in kinds)
    for key, data in heard:
        document = json.loads(data)
        if key.endswith("/measures"):
            # The only positions in it are those that the receiver itself measured.
            assert set(document.get("Sensors", {})) <= {"Proximity", "Encoders", "Compass", "Bumper", "GPS"}
        elif "/body/" in key:
            assert not {"WheelRatio", "WheelScale", "TrackRatio"} & document["Robot"].keys()
        else:
            assert not {"X", "Y", "Heading", "Speed", "Entity"} & document.keys(), (key, document)
