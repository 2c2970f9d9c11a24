"""The paper's main scene as processes: what must hold holds, and a run is a function of its seed."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from tests.e2e.stage import run


def play(folder: Path, *words: str, **environment: str) -> dict[str, Any]:
    """Run figure6 and return its result."""
    file = folder / "result.json"
    done = run("intellwheels_experiments", "figure6", "--json", str(file), "--logs", str(folder / "logs"), *words,
               timeout=180.0, **environment)  # fmt: skip
    logs = "".join(f"--- {log}\n{log.read_text()[-2000:]}" for log in (folder / "logs").glob("*.log"))
    assert done.returncode == 0, done.stdout + done.stderr + logs
    result = json.loads(file.read_text())
    assert isinstance(result, dict)
    return result


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("figure6")


@pytest.fixture(scope="module")
def first(folder: Path) -> dict[str, Any]:
    return play(folder, "--log", str(folder / "run.log"))


def test_chairs_reach_their_goals_without_a_contact(first: dict[str, Any]) -> None:
    assert first["held"] is True
    assert first["contacts"] == 0
    rows = {row["name"]: row for row in first["agents"]}
    assert [rows[name]["reached"] for name in ("chair1", "chair2", "chair3")] == [True, True, True]
    assert [row["contacts"] for row in first["agents"]] == [0, 0, 0, 0, 0]


def test_table_was_never_moved(first: dict[str, Any]) -> None:
    (table,) = [row for row in first["agents"] if row["name"] == "table"]
    assert (table["path"], table["turned"]) == (0.0, 0.0)


def test_door_opened_for_what_its_sensors_saw_and_closed_again(folder: Path, first: dict[str, Any]) -> None:
    (door,) = [row for row in first["agents"] if row["name"] == "door"]
    assert math.degrees(door["turned"]) > 80.0
    lines = [json.loads(line) for line in (folder / "run.log").read_text().splitlines()]
    acts = [line.get("Inputs", {}).get("Actions", {}) for line in lines[1:]]
    says = {name: [act[name]["Say"] for act in acts if "Say" in act.get(name, {})] for name in ("door", "chair1")}
    assert says["door"] == ["door closed", "door opening", "door open", "door closing", "door closed"]
    # Nobody told it: what opened it was what it saw.
    assert says["chair1"] == []


def test_log_of_the_run_is_run_again_to_the_same_hashes(folder: Path, first: dict[str, Any]) -> None:
    done = run("intellwheels_server", "--resimulate", str(folder / "run.log"))
    assert done.returncode == 0, done.stdout + done.stderr
    assert first["hash"] in done.stdout


def test_same_seed_gives_the_same_hash(tmp_path: Path, first: dict[str, Any]) -> None:
    again = play(tmp_path)
    assert (again["hash"], again["ticks"]) == (first["hash"], first["ticks"])


def test_other_seed_gives_another_hash(tmp_path: Path, first: dict[str, Any]) -> None:
    assert play(tmp_path, "--seed", "2")["hash"] != first["hash"]


def test_cast_that_speaks_xml_gives_the_same_hash(tmp_path: Path, first: dict[str, Any]) -> None:
    assert play(tmp_path, "--encoding", "xml")["hash"] == first["hash"]


def test_generic_processor_gives_the_same_hash(tmp_path: Path, first: dict[str, Any]) -> None:
    assert play(tmp_path, NUMBA_CPU_NAME="generic")["hash"] == first["hash"]
