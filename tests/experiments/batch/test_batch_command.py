"""A batch from its stored runs to its files and lines. Finished runs are not repeated."""

from __future__ import annotations

import dataclasses
import functools
import io
import json
import pickle
import shutil
import tempfile
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest
from rich.console import Console

from intellwheels_experiments.batch import report_drawings
from intellwheels_experiments.batch.batch_command import (
    OtherBatchError,
    merge_parts,
    perform_batch,
    perform_part,
    remaining,
    shortfall,
    show,
    write_files,
)
from intellwheels_experiments.batch.batch_parts import Part
from intellwheels_experiments.batch.experiment_rows import rows_of
from intellwheels_experiments.batch.run_batch import Batch
from intellwheels_experiments.batch.run_measures import RunMeasures, RunSeries, measure_run
from intellwheels_experiments.batch.run_store import StoredRun, run_folder, store_run
from intellwheels_experiments.batch.scratch_folders import scratch_folder
from intellwheels_experiments.batch.summary import Summary
from intellwheels_maps import floor, scene
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Scene
from tests.experiments.runs import straight
from tests.experiments.scenes import write_scene

FLOOR = floor("corridor15m")
DRAWN: dict[bytes, object] = {}
"""The drawings so far, by what was drawn: matplotlib takes longer than all else here."""


@pytest.fixture(autouse=True)
def drawn_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw what is the same once; `test_report_drawings` and `test_html_report` always draw."""
    for name in ("paths", "along", "drift", "intervals"):
        monkeypatch.setattr(report_drawings, name, remembered(getattr(report_drawings, name)))


def remembered(draw: Callable[..., object]) -> Callable[..., object]:
    def drawn(*arguments: object) -> object:
        key = pickle.dumps((draw.__name__, arguments))
        if key not in DRAWN:
            DRAWN[key] = draw(*arguments)
        return DRAWN[key]

    return drawn


def finished_batch(folder: Path, seeds: int = 2) -> tuple[Batch, Scene]:
    """Return a batch of which all runs are finished."""
    path = write_scene(folder)
    document = scene(str(path))
    wanted = Batch(
        rows=rows_of(document), seeds=tuple(str(seed) for seed in range(1, seeds + 1)), subject="chair", floor=FLOOR,
        source=str(path), folder=folder, out=folder / "out", jobs=1, timeout=60.0,
    )  # fmt: skip
    for row in wanted.rows:
        for seed in wanted.seeds:
            aside = 0.1 if row.name == "unlike" else 0.0
            numbers, series = measured(aside)
            store_run(wanted.out, StoredRun(row=row.name, seed=seed, measured=numbers, wall=float(seed)), series)
    return wanted, document


@functools.cache
def measured(aside: float) -> tuple[RunMeasures, RunSeries]:
    """Return the measures of the run that starts beside the middle by so many metres."""
    with tempfile.TemporaryDirectory() as folder:
        document = scene(str(write_scene(Path(folder))))
    return measure_run(straight(aside=aside), document, FLOOR, "chair", real=False)


def shown(summary: Summary, *, terminal: bool = False) -> str:
    text = io.StringIO()
    show(summary, Console(file=text, force_terminal=terminal, width=160))
    return text.getvalue()


def test_finished_batch_starts_nothing_and_writes_its_files(tmp_path: Path) -> None:
    wanted, document = finished_batch(tmp_path)
    # The scene's file does not exist, so any start of a simulator would fail.
    wanted = replace(wanted, source=str(tmp_path / "gone.xml"))
    printed = io.StringIO()
    summary = perform_batch(wanted, document, Console(file=printed), threading.Event())
    assert "resuming: 4 of 4 runs are done" in printed.getvalue()
    assert [(line.name, line.runs, line.died) for line in summary.lines] == [("equal", 2, ()), ("unlike", 2, ())]
    names = {"batch.json", "batch.csv", "summary.json", "junit.xml", "report.html"}
    assert names <= {path.name for path in wanted.out.iterdir()}
    assert len((wanted.out / "batch.csv").read_text().splitlines()) == 1 + 4
    assert json.loads((wanted.out / "summary.json").read_text())["lines"][0]["name"] == "equal"


def test_csv_is_the_same_however_long_the_runs_took(tmp_path: Path) -> None:
    wanted, document = finished_batch(tmp_path)
    write_files(wanted, document)
    before = [(wanted.out / name).read_bytes() for name in ("batch.csv", "summary.json", "junit.xml")]
    for path in wanted.out.glob("runs/*/*/result.json"):
        path.write_text(path.read_text().replace('"wall": ', '"wall": 10'))
    write_files(wanted, document)
    assert [(wanted.out / name).read_bytes() for name in ("batch.csv", "summary.json", "junit.xml")] == before


def test_folder_of_another_scene_is_refused_and_left_as_it_was(tmp_path: Path) -> None:
    wanted, document = finished_batch(tmp_path)
    perform_batch(wanted, document, Console(file=io.StringIO()), threading.Event())
    before = {path: path.read_bytes() for path in wanted.out.iterdir() if path.is_file()}
    with pytest.raises(OtherBatchError, match="got another batch's"):
        perform_batch(wanted, scene("table1"), Console(file=io.StringIO()), threading.Event())
    assert {path: path.read_bytes() for path in before} == before


def test_script_reads_lines_and_a_person_a_table(tmp_path: Path) -> None:
    wanted, document = finished_batch(tmp_path)
    summary = write_files(wanted, document)
    lines = shown(summary).splitlines()
    assert [line.split()[0:2] for line in lines[:2]] == [["row", "name=equal"], ["row", "name=unlike"]]
    assert lines[2].startswith("compare first=unlike second=equal expect=- difference=+0.000")
    assert "┃" in shown(summary, terminal=True)


def test_titles_with_brackets_are_printed_unchanged(tmp_path: Path) -> None:
    wanted, document = finished_batch(tmp_path)
    rows = tuple(dataclasses.replace(row, title=f"{row.name} [/m]") for row in wanted.rows)
    summary = write_files(dataclasses.replace(wanted, rows=rows), document)
    assert "unlike [/m]" in shown(summary, terminal=True)


def test_missing_run_is_reported_and_counts_nowhere(tmp_path: Path) -> None:
    wanted, document = finished_batch(tmp_path)
    (wanted.out / "runs" / "equal" / "2" / "result.json").unlink()
    summary = write_files(wanted, document)
    assert [(line.runs, line.died, line.missing) for line in summary.lines] == [(1, (), ("2",)), (2, (), ())]
    assert "equal, seed 2: it was not run" in (wanted.out / "report.html").read_text()
    assert len((wanted.out / "batch.csv").read_text().splitlines()) == 1 + 3
    lines = shown(summary).splitlines()
    assert lines[0].endswith("died=0 missing=1")
    assert lines[2] == "compare first=unlike second=equal expect=- found=incomplete"


def test_wheels_are_not_estimated_from_a_part_of_the_squares(tmp_path: Path) -> None:
    document = scene("umbmark")
    (tmp_path / "out").mkdir()
    wanted = Batch(
        rows=rows_of(document), seeds=("1",), subject="chair", floor=floor(document.map), source="umbmark",
        folder=None, out=tmp_path / "out", jobs=1, timeout=180.0,
    )  # fmt: skip
    assert write_files(wanted, document).umbmark is None


def test_batch_says_how_many_runs_it_has(tmp_path: Path) -> None:
    wanted, document = finished_batch(tmp_path)
    for part, said in (
        (Part(1, 1), "4 runs: 2 rows x 2 seeds\n"),
        (Part(2, 4), "1 run: part 2/4 of 2 rows x 2 seeds\n"),
    ):
        printed = io.StringIO()
        perform_part(replace(wanted, part=part), document, Console(file=printed), threading.Event())
        assert printed.getvalue().startswith(said)


def test_remaining_time_follows_from_the_runs_made_now() -> None:
    assert remaining(10.0, 5, 275) == "0:09:10"
    assert remaining(7200.0, 1, 2) == "4:00:00"
    assert remaining(7200.0, 1, 0) == "0:00:00"


def test_interrupted_batch_says_what_is_done_and_judges_nothing(tmp_path: Path) -> None:
    wanted, document = finished_batch(tmp_path)
    for seed in wanted.seeds:
        shutil.rmtree(run_folder(wanted.out, "equal", seed))
    stop = threading.Event()
    stop.set()
    summary = perform_batch(wanted, document, Console(file=io.StringIO()), stop)
    assert [(line.runs, line.died, len(line.missing)) for line in summary.lines] == [(0, (), 2), (2, (), 0)]
    assert summary.comparisons[0].verdict == "incomplete"
    done = "interrupted: 2 of 4 runs are done; run the same command again to resume"
    assert shortfall(wanted, interrupted=True) == done
    assert shortfall(wanted, interrupted=False).startswith("incomplete: 2 of 4 runs are missing; ")


def test_batch_without_missing_runs_has_no_shortfall(tmp_path: Path) -> None:
    wanted, _ = finished_batch(tmp_path)
    assert shortfall(wanted, interrupted=True) == ""
    assert shortfall(wanted, interrupted=False) == ""


def test_what_killed_workers_left_is_deleted_at_the_next_start(tmp_path: Path) -> None:
    wanted, document = finished_batch(tmp_path)
    with scratch_folder(wanted.out, "worker") as used:
        left = used.with_name(f"{used.name}x")
        left.mkdir()
        perform_batch(wanted, document, Console(file=io.StringIO()), threading.Event())
        assert used.is_dir()
        assert not left.exists()


@pytest.mark.process
def test_umbmark_finds_the_wheels_that_the_chair_has(tmp_path: Path) -> None:
    document = scene("umbmark")
    wanted = Batch(
        rows=rows_of(document), seeds=("1", "2"), subject="chair", floor=floor(document.map), source="umbmark",
        folder=None, out=tmp_path / "out", jobs=2, timeout=180.0,
    )  # fmt: skip
    summary = perform_batch(wanted, document, Console(file=io.StringIO()), threading.Event())
    found = summary.umbmark
    assert found is not None
    assert (found.seeds, found.wheels.true, found.base.true) == (2, 1.002, 1.005)
    # The tolerance is the method's own error for these factors, as in test_metrics, and the wheels' noise.
    assert found.wheels.found == pytest.approx(1.002, abs=6e-4)
    assert found.base.found == pytest.approx(1.005, abs=6e-4)
    lines = [line.split() for line in shown(summary).splitlines() if line.startswith("umbmark ")]
    assert [line[1:3] for line in lines] == [["figure=E_d", "true=1.0020"], ["figure=E_b", "true=1.0050"]]
    assert "UMBmark E_b: true 1.0050, found 1.00" in shown(summary, terminal=True)
    report = (wanted.out / "report.html").read_text()
    assert "<h2>UMBmark</h2>" in report
    assert f"{found.base.found:.4f}" in report


def test_merged_parts_have_the_files_of_the_whole_batch(tmp_path: Path) -> None:
    whole, document = finished_batch(tmp_path)
    quiet = Console(file=io.StringIO())
    perform_batch(whole, document, quiet, threading.Event())
    parts = []
    for number in (1, 2, 3):
        mine = replace(whole, out=tmp_path / f"part{number}", part=Part(number, 3))
        for index, (row, seed) in enumerate((row.name, seed) for row in whole.rows for seed in whole.seeds):
            if mine.part.holds(index):
                shutil.copytree(run_folder(whole.out, row, seed), run_folder(mine.out, row, seed))
        made = perform_part(mine, document, quiet, threading.Event())
        assert len(made) == (2 if number == 1 else 1)
        assert {path.name for path in mine.out.iterdir()} == {"runs", "batch.json"}
        parts.append(mine.out)
    merged = replace(whole, out=tmp_path / "merged", source=str(tmp_path / "gone.xml"))
    copied, summary = merge_parts(merged, document, parts)
    assert (copied, sum(line.runs for line in summary.lines)) == (4, 4)
    for name in ("batch.csv", "summary.json", "junit.xml"):
        assert (merged.out / name).read_bytes() == (whole.out / name).read_bytes()


def test_missing_part_is_a_run_that_was_not_run(tmp_path: Path) -> None:
    whole, document = finished_batch(tmp_path)
    perform_part(replace(whole, part=Part(1, 2)), document, Console(file=io.StringIO()), threading.Event())
    shutil.rmtree(run_folder(whole.out, "unlike", "2"))
    _, summary = merge_parts(replace(whole, out=tmp_path / "merged"), document, [whole.out])
    assert [(line.name, line.died, line.missing) for line in summary.lines] == [
        ("equal", (), ()), ("unlike", (), ("2",))
    ]  # fmt: skip


def test_folder_of_another_batch_is_not_merged(tmp_path: Path) -> None:
    whole, document = finished_batch(tmp_path)
    perform_batch(whole, document, Console(file=io.StringIO()), threading.Event())
    target = replace(whole, out=tmp_path / "merged")
    other = msgspec.structs.replace(document, period=0.1)
    with pytest.raises(WireError, match="expected a part of this batch, got the folder of another batch"):
        merge_parts(target, other, [whole.out])
    with pytest.raises(WireError, match="expected the folder of a part of this batch, got"):
        merge_parts(target, document, [tmp_path / "nowhere"])
    assert not target.out.exists()
