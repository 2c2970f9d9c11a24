"""A batch with real processes: every row runs with every seed, finished runs stay, and dead runs are named."""

from __future__ import annotations

import csv
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from intellwheels_experiments.batch import run_batch as run_batch_module
from intellwheels_experiments.batch.experiment_rows import rows_of
from intellwheels_experiments.batch.run_batch import Batch, pending_runs, read_batch, run_batch
from intellwheels_experiments.batch.run_store import StoredRun, read_tum, run_folder, runs_csv
from intellwheels_maps import floor, scene
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Map, Robot, Uniform
from tests.experiments.scenes import write_scene

pytestmark = pytest.mark.process


def batch(folder: Path, seeds: int, *, jobs: int = 1, dies: bool = False, laboratory: bool = False) -> Batch:
    path = write_scene(folder, dies=dies, laboratory=laboratory)
    out = folder / "out"
    out.mkdir(exist_ok=True)
    return Batch(
        rows=rows_of(scene(str(path))), seeds=tuple(str(seed) for seed in range(1, seeds + 1)), subject="chair",
        floor=floor("corridor15m"), source=str(path), folder=folder, out=out, jobs=jobs, timeout=120.0,
    )  # fmt: skip


def run(wanted: Batch) -> list[StoredRun]:
    runs_made: list[StoredRun] = []
    run_batch(wanted, runs_made.append, threading.Event())
    return runs_made


def test_every_row_runs_with_every_seed_on_workers_that_stay_alive(tmp_path: Path) -> None:
    wanted = batch(tmp_path, 3, jobs=2)
    runs_made = run(wanted)
    assert sorted((one.row, one.seed) for one in runs_made) == [
        (row, seed) for row in ("equal", "unlike") for seed in "123"
    ]
    runs = read_batch(wanted)
    assert [one.died for one in runs] == [""] * 6
    hashes = [one.measured.hash for one in runs if one.measured]
    assert len(set(hashes)) == 6
    log = run_folder(wanted.out, "unlike", "3") / "input.jsonl"
    again = subprocess.run(
        [sys.executable, "-m", "intellwheels_server", "--resimulate", str(log)],
        capture_output=True,
        text=True,
        check=True,
    )
    assert again.stdout == f"same ticks=40 tick=40 hash={hashes[-1]}\n"


def test_run_is_the_same_as_the_first_of_its_worker_or_as_a_later_one(tmp_path: Path) -> None:
    wanted = batch(tmp_path, 2)
    run(wanted)
    before = runs_csv(read_batch(wanted))
    (run_folder(wanted.out, "equal", "2") / "result.json").unlink()
    assert [(row.name, seeds) for row, seeds in pending_runs(wanted)] == [("equal", ("2",))]
    assert [(one.row, one.seed) for one in run(wanted)] == [("equal", "2")]
    assert runs_csv(read_batch(wanted)) == before


def test_run_that_dies_is_named_and_the_others_go_on(tmp_path: Path) -> None:
    wanted = batch(tmp_path, 3, dies=True)
    runs_made = {(one.row, one.seed): one for one in run(wanted)}
    assert {key for key, one in runs_made.items() if one.died} == {("equal", "2"), ("unlike", "2")}
    assert "failed on purpose" in runs_made["equal", "2"].died
    assert runs_made["equal", "3"].measured is not None
    # They are run again, this time as the first of their worker.
    assert [one.died for one in run(wanted)] == ["", ""]


def test_each_seed_has_the_start_and_the_wheels_that_it_draws(tmp_path: Path) -> None:
    nominal = batch(tmp_path, 2, jobs=2)
    uniform = (
        Uniform(place="start", name="Y", low=0.1, high=0.3),
        Uniform(agent="chair", name="WheelRatio", low=-0.01, high=0.01),
    )
    wanted = replace(nominal, rows=(replace(nominal.rows[1], uniform=uniform),))
    assert [seeds for _, seeds in pending_runs(wanted)] == [("1",), ("2",)]
    run(wanted)
    for seed, found in zip("12", read_batch(wanted), strict=True):
        assert found.died == ""
        folder = run_folder(wanted.out, "unlike", seed)
        true = read_tum(folder / "true.tum")
        assert true is not None
        assert true[0, 2] == pytest.approx(found.drawn["place start.Y"], abs=1e-6)
        robot = msgspec.json.decode((folder / "robot.json").read_bytes(), type=Robot)
        assert robot.wheel_ratio == pytest.approx(1.02 + found.drawn["chair.WheelRatio"], abs=1e-6)
    before = runs_csv(read_batch(wanted))
    assert [line["drawn"].count("=") for line in csv.DictReader(before.splitlines())] == [2, 2]
    (run_folder(wanted.out, "unlike", "2") / "result.json").unlink()
    run(wanted)
    assert runs_csv(read_batch(wanted)) == before


def test_map_that_is_invalid_for_a_seed_is_why_its_run_died(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def invalid(*_: object) -> Map:
        raise WireError("value", "Uniform: expected a valid map, got another")

    monkeypatch.setattr(run_batch_module, "varied_floor", invalid)
    nominal = batch(tmp_path, 2)
    uniform = (Uniform(place="start", name="Y", low=0.1, high=0.3),)
    wanted = replace(nominal, rows=(replace(nominal.rows[0], uniform=uniform),))
    assert [one.died for one in run(wanted)] == ["Uniform: expected a valid map, got another"] * 2


def test_chair_of_a_laboratory_is_mirrored_away_from_its_true_pose(tmp_path: Path) -> None:
    wanted = batch(tmp_path, 2, laboratory=True)
    run(wanted)
    before = runs_csv(read_batch(wanted))
    real = [one.measured for one in read_batch(wanted) if one.row == "real"]
    assert all(one is not None and one.odometry_error is not None and one.odometry_error > 1e-3 for one in real)
    assert (run_folder(wanted.out, "real", "2") / "image.jsonl").exists()
    (run_folder(wanted.out, "real", "2") / "result.json").unlink()
    run(wanted)
    assert runs_csv(read_batch(wanted)) == before
