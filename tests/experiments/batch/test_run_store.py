from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from intellwheels_experiments.batch.run_measures import measured
from intellwheels_experiments.batch.run_store import done, keep, place_of, read_tum, table, tum
from intellwheels_maps import floor, scene
from tests.experiments.runs import kept, straight


def test_trajectory_is_written_as_tum_has_it_and_read_again(tmp_path: Path) -> None:
    poses = np.array([[1.0, 2.0, math.pi / 2.0], [-1.0, 0.5, -3.0]])
    text = tum(np.array([0.0, 0.05]), poses)
    assert text.splitlines()[0] == "0.000 1.000000 2.000000 0 0 0 0.707106781 0.707106781"
    (tmp_path / "t.tum").write_text(text)
    found = read_tum(tmp_path / "t.tum")
    assert found is not None
    assert found[:, 1:] == pytest.approx(poses, abs=1e-6)
    assert read_tum(tmp_path / "none.tum") is None


def test_run_is_done_when_its_result_is_there_and_not_when_it_died(tmp_path: Path) -> None:
    assert done(tmp_path, "a", "1") is None
    keep(tmp_path, kept("a", "1"))
    keep(tmp_path, kept("a", "2", died="server: exit 1"))
    assert done(tmp_path, "a", "1") == kept("a", "1")
    assert done(tmp_path, "a", "2") is None


def test_half_a_result_is_none(tmp_path: Path) -> None:
    keep(tmp_path, kept("a", "1"))
    path = place_of(tmp_path, "a", "1") / "result.json"
    path.write_bytes(path.read_bytes()[:50])
    assert done(tmp_path, "a", "1") is None


def test_files_of_a_run_are_there(tmp_path: Path) -> None:
    numbers, course = measured(straight(hits=(5,)), scene("table1"), floor("corridor15m"), "chair", real=True)
    log = tmp_path / "log"
    log.write_text("a log\n")
    run = kept("a", "1")
    keep(tmp_path, run, course, log)
    names = {path.name for path in place_of(tmp_path, "a", "1").iterdir()}
    assert names == {
        "input.jsonl", "true.tum", "reported.tum", "command.tum", "contacts.csv", "along.csv", "robot.json",
        "measures.csv", "result.json",
    }  # fmt: skip
    assert (place_of(tmp_path, "a", "1") / "contacts.csv").read_text().splitlines()[1] == "5,chair,wall,0.125,0.0,0.1"
    assert numbers.contacts_physical == 1


def test_table_has_a_line_a_run_and_no_wall_time(tmp_path: Path) -> None:
    lines = list(csv.DictReader(table([kept("a", "1"), kept("a", "2", died="why")]).splitlines()))
    assert [line["died"] for line in lines] == ["no", "yes"]
    assert (lines[0]["success"], lines[0]["clearance"], lines[0]["effort"], lines[1]["time"]) == ("yes", "0.2", "", "")
    assert "wall" not in lines[0]
