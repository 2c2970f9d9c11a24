from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from intellwheels_experiments.batch.run_measures import measure_run
from intellwheels_experiments.batch.run_store import (
    StoredRun,
    finished_run,
    read_tum,
    run_folder,
    runs_csv,
    store_run,
    tum,
)
from intellwheels_maps import floor, scene
from tests.experiments.runs import stored, straight


def test_trajectory_is_written_in_tum_format_and_read_back(tmp_path: Path) -> None:
    poses = np.array([[1.0, 2.0, math.pi / 2.0], [-1.0, 0.5, -3.0]])
    text = tum(np.array([0.0, 0.05]), poses)
    assert text.splitlines()[0] == "0.000 1.000000 2.000000 0 0 0 0.707106781 0.707106781"
    (tmp_path / "t.tum").write_text(text)
    found = read_tum(tmp_path / "t.tum")
    assert found is not None
    assert found[:, 1:] == pytest.approx(poses, abs=1e-6)
    assert read_tum(tmp_path / "none.tum") is None


def test_run_is_finished_once_it_has_a_result_unless_it_died(tmp_path: Path) -> None:
    assert finished_run(tmp_path, "a", "1") is None
    store_run(tmp_path, stored("a", "1"))
    store_run(tmp_path, stored("a", "2", died="server: exit 1"))
    assert finished_run(tmp_path, "a", "1") == stored("a", "1")
    assert finished_run(tmp_path, "a", "2") is None


def test_half_a_result_counts_as_none(tmp_path: Path) -> None:
    store_run(tmp_path, stored("a", "1"))
    path = run_folder(tmp_path, "a", "1") / "result.json"
    path.write_bytes(path.read_bytes()[:50])
    assert finished_run(tmp_path, "a", "1") is None


def test_run_has_all_its_files(tmp_path: Path) -> None:
    numbers, series = measure_run(straight(hits=(5,)), scene("table1"), floor("corridor15m"), "chair", real=True)
    log = tmp_path / "log"
    log.write_text("a log\n")
    run = stored("a", "1")
    store_run(tmp_path, run, series, log)
    names = {path.name for path in run_folder(tmp_path, "a", "1").iterdir()}
    assert names == {
        "input.jsonl", "true.tum", "reported.tum", "command.tum", "contacts.csv", "along.csv", "robot.json",
        "measures.csv", "result.json",
    }  # fmt: skip
    assert (run_folder(tmp_path, "a", "1") / "contacts.csv").read_text().splitlines()[1] == "5,chair,wall,0.125,0.0,0.1"
    assert numbers.contacts_physical == 1


def test_csv_has_a_line_per_run_and_no_wall_time(tmp_path: Path) -> None:
    lines = list(
        csv.DictReader(
            runs_csv([stored("a", "1"), stored("a", "2", died="why"), StoredRun(row="a", seed="3")]).splitlines()
        )
    )
    assert [line["died"] for line in lines] == ["no", "yes"]
    assert (lines[0]["success"], lines[0]["clearance"], lines[0]["effort"], lines[1]["time"]) == ("yes", "0.2", "", "")
    assert "wall" not in lines[0]
