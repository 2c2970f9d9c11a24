"""`iw-run table1`: rows, numbers and report. The runs equal those stored for the hypotheses.

One row of each kind of chair runs one seed with the suite; all rows run five with the mark soak.
"""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import msgspec
import pytest

from intellwheels_experiments.batch.summary import Summary

STORED = Path(__file__).parents[1] / "experiments" / "table1" / "batch.csv"
LIMIT = 600.0
EVERY = (
    "real-manual", "virtual-manual", "real-autonomous", "virtual-autonomous", "augmented-raw", "augmented-calibrated",
    "augmented-corrected",
)  # fmt: skip
ONE_OF_EACH = ("real-manual", "virtual-autonomous", "augmented-corrected")
_OUTCOME = ("died", "success", "collided", "contacts_physical", "contacts_virtual", "hash")


def lines(file: Path) -> dict[tuple[str, str], dict[str, str]]:
    with file.open() as text:
        return {(line["row"], line["seed"]): line for line in csv.DictReader(text)}


class Batch(NamedTuple):
    """A batch that has ended: its seeds, what it printed, and its folder."""

    rows: tuple[str, ...]
    seeds: int
    printed: str
    out: Path


@pytest.fixture(scope="module", params=[(ONE_OF_EACH, 1), pytest.param((EVERY, 5), marks=pytest.mark.soak)],
                ids=["few", "all"])  # fmt: skip
def batch(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Batch:
    rows, seeds = request.param
    out = tmp_path_factory.mktemp("table1")
    chosen = () if rows is EVERY else [word for row in rows for word in ("--row", row)]
    done = subprocess.run(
        [sys.executable, "-m", "intellwheels_experiments", "table1", *chosen, "--seeds", str(seeds), "--jobs", "2",
         "--out", str(out)],
        capture_output=True, text=True, timeout=LIMIT, check=False,
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    return Batch(rows, seeds, done.stdout, out)


def test_every_row_has_runs_that_equal_the_stored_ones(batch: Batch) -> None:
    found, stored = lines(batch.out / "batch.csv"), lines(STORED)
    assert {row for row, _ in stored} == set(EVERY)
    wanted = {key: line for key, line in stored.items() if key[0] in batch.rows and int(key[1]) <= batch.seeds}
    assert len(wanted) == len(batch.rows) * batch.seeds
    assert found.keys() == wanted.keys()
    assert {key: [line[name] for name in _OUTCOME] for key, line in found.items()} == {
        key: [line[name] for name in _OUTCOME] for key, line in wanted.items()
    }


def test_output_and_report_have_the_numbers_of_the_runs(batch: Batch) -> None:
    rows, seeds, printed, out = batch
    found = lines(out / "batch.csv")
    summary = msgspec.json.decode((out / "summary.json").read_bytes(), type=Summary)
    report = (out / "report.html").read_text()
    assert [line.name for line in summary.lines] == list(rows)
    for line in summary.lines:
        runs = [one for (row, _), one in found.items() if row == line.name]
        assert (line.runs, line.succeeded) == (seeds, sum(one["success"] == "yes" for one in runs))
        assert sum(f"row name={line.name} " in text for text in printed.splitlines()) == 1
        assert line.title in report
    assert (out / "junit.xml").exists()
    assert "<svg" in report
