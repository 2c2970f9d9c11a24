from __future__ import annotations

import dataclasses
import threading
from pathlib import Path

import pytest

from intellwheels_experiments.batch.experiment_rows import Row, rows_of
from intellwheels_experiments.batch.run_batch import Batch, read_batch, run_batch
from intellwheels_experiments.batch.run_store import StoredRun, read_tum, run_folder
from intellwheels_experiments.batch.what_if import BranchError, perform_branch
from intellwheels_experiments.run.cast_changes import with_changes
from intellwheels_maps import floor, scene
from tests.experiments.scenes import write_scene


def with_option(row: Row, option: str) -> Row:
    return dataclasses.replace(row, scene=with_changes(row.scene, [], [option]))


@pytest.fixture
def parent(tmp_path: Path) -> tuple[Batch, Path]:
    path = write_scene(tmp_path)
    rows = rows_of(scene(str(path)))[:1]
    out = tmp_path / "out"
    out.mkdir()
    batch = Batch(
        rows=rows, seeds=("1", "2"), subject="chair", floor=floor("corridor15m"), source=str(path), folder=tmp_path,
        out=out, jobs=1, timeout=120.0,
    )  # fmt: skip
    runs: list[StoredRun] = []
    run_batch(batch, runs.append, threading.Event())
    return batch, run_folder(out, "equal", "2") / "input.jsonl"


@pytest.mark.process
def test_branch_equals_its_parent_up_to_the_tick_and_differs_after_it(parent: tuple[Batch, Path]) -> None:
    batch, log = parent
    changed = with_option(batch.rows[0], "chair.left=0.1")
    summary = perform_branch(batch, scene(batch.source), changed, log, 20, threading.Event())
    assert [line.title for line in summary.lines] == ["equal: as recorded", "equal: chair.left=0.1 from tick 20 on"]
    was, branch = (read_tum(run_folder(batch.out, name, "2") / "true.tum") for name in ("parent", "branch"))
    assert was is not None
    assert branch is not None
    assert (was[:21] == branch[:21]).all()
    assert abs(branch[-1, 3] - was[-1, 3]) > 0.1


@pytest.mark.process
def test_branch_with_the_same_mind_has_the_same_hash(parent: tuple[Batch, Path]) -> None:
    batch, log = parent
    perform_branch(batch, scene(batch.source), batch.rows[0], log, 20, threading.Event())
    files = [run_folder(batch.out, name, "2") / "measures.csv" for name in ("parent", "branch")]
    was, branch = (path.read_text().splitlines()[1].split(",", 1)[1] for path in files)
    assert was == branch
    assert was.split(",")[-1] == next(
        run.measured.hash for run in read_batch(batch) if run.seed == "2" and run.measured
    )


@pytest.mark.process
def test_branch_of_a_chair_in_a_laboratory_equals_its_parent_in_both_worlds_up_to_the_tick(tmp_path: Path) -> None:
    path = write_scene(tmp_path, laboratory=True)
    row = rows_of(scene(str(path)))[2]
    out = tmp_path / "out"
    out.mkdir()
    batch = Batch(
        rows=(row,), seeds=("1",), subject="chair", floor=floor("corridor15m"), source=str(path), folder=tmp_path,
        out=out, jobs=1, timeout=120.0,
    )  # fmt: skip
    runs: list[StoredRun] = []
    run_batch(batch, runs.append, threading.Event())
    log = run_folder(out, "real", "1") / "input.jsonl"
    perform_branch(batch, scene(batch.source), with_option(row, "chair.left=0.1"), log, 10, threading.Event())
    for name in ("true", "reported"):
        was, branch = (read_tum(run_folder(out, run, "1") / f"{name}.tum") for run in ("parent", "branch"))
        assert was is not None
        assert branch is not None
        assert (was[:11] == branch[:11]).all()
        end = min(len(was), len(branch)) - 2
        assert abs(branch[end, 3] - was[end, 3]) > 0.02
    assert (run_folder(out, "branch", "1") / "image.jsonl").exists()
    log.with_name("image.jsonl").unlink()
    with pytest.raises(BranchError, match="expected the mirror world's log beside the laboratory's"):
        perform_branch(batch, scene(batch.source), row, log, 20, threading.Event())


@pytest.mark.process
def test_tick_beyond_the_log_is_refused(parent: tuple[Batch, Path]) -> None:
    batch, log = parent
    with pytest.raises(BranchError, match="expected a tick in"):
        perform_branch(batch, scene(batch.source), batch.rows[0], log, 4000, threading.Event())
