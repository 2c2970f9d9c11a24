"""`iw-run table1` with five seeds: rows, numbers and report. The runs equal those stored for the hypotheses."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

from intellwheels_experiments.batch.summary import Summary

STORED = Path(__file__).parents[1] / "experiments" / "table1" / "batch.csv"
SEEDS = 5
LIMIT = 600.0
_OUTCOME = ("died", "success", "collided", "contacts_physical", "contacts_virtual", "hash")


def lines(file: Path) -> dict[tuple[str, str], dict[str, str]]:
    with file.open() as text:
        return {(line["row"], line["seed"]): line for line in csv.DictReader(text)}


@pytest.fixture(scope="module")
def batch(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    out = tmp_path_factory.mktemp("table1")
    done = subprocess.run(
        [sys.executable, "-m", "intellwheels_experiments", "table1", "--seeds", str(SEEDS), "--jobs", "2",
         "--out", str(out)],
        capture_output=True, text=True, timeout=LIMIT, check=False,
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    return done.stdout, out


def test_every_row_has_five_runs_that_equal_the_stored_ones(batch: tuple[str, Path]) -> None:
    found, stored = lines(batch[1] / "batch.csv"), lines(STORED)
    wanted = {key: line for key, line in stored.items() if int(key[1]) <= SEEDS}
    assert len(wanted) == 7 * SEEDS
    assert found.keys() == wanted.keys()
    assert {key: [line[name] for name in _OUTCOME] for key, line in found.items()} == {
        key: [line[name] for name in _OUTCOME] for key, line in wanted.items()
    }


def test_output_and_report_have_the_numbers_of_the_runs(batch: tuple[str, Path]) -> None:
    printed, out = batch
    found = lines(out / "batch.csv")
    summary = msgspec.json.decode((out / "summary.json").read_bytes(), type=Summary)
    report = (out / "report.html").read_text()
    assert len(summary.lines) == 7
    for line in summary.lines:
        runs = [one for (row, _), one in found.items() if row == line.name]
        assert (line.runs, line.succeeded) == (SEEDS, sum(one["success"] == "yes" for one in runs))
        assert sum(f"row name={line.name} " in text for text in printed.splitlines()) == 1
        assert line.title in report
    assert (out / "junit.xml").exists()
    assert "<svg" in report
