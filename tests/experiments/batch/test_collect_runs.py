"""Runs of other folders: each is copied once and whole, and a finished run is never replaced."""

from __future__ import annotations

from pathlib import Path

from intellwheels_experiments.batch.collect_runs import collect_runs
from intellwheels_experiments.batch.run_store import finished_run, load_run, run_folder, store_run
from tests.experiments.runs import stored


def test_runs_are_collected_once_and_finished_ones_stay(tmp_path: Path) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    store_run(here, stored("a", "1"))
    for seed in ("1", "2"):
        store_run(there, stored("a", seed))
    store_run(there, stored("b", "1", died="server: exit 1"))
    (run_folder(there, "a", "2") / "true.tum").write_text("a trajectory\n")
    before = (run_folder(here, "a", "1") / "result.json").stat().st_mtime_ns
    assert collect_runs(here, [there], ["a", "b"], ["1", "2"]) == 2
    assert (run_folder(here, "a", "1") / "result.json").stat().st_mtime_ns == before
    assert finished_run(here, "a", "2") == stored("a", "2")
    assert (run_folder(here, "a", "2") / "true.tum").read_text() == "a trajectory\n"
    died = load_run(here, "b", "1")
    assert died is not None
    assert died.died == "server: exit 1"
    assert collect_runs(here, [there], ["a", "b"], ["1", "2"]) == 0
    assert {path.name for path in here.iterdir()} == {"runs"}


def test_run_that_finished_elsewhere_replaces_one_that_died(tmp_path: Path) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    store_run(here, stored("a", "1", died="server: exit 1"))
    store_run(there, stored("a", "1"))
    assert collect_runs(here, [there], ["a"], ["1"]) == 1
    assert finished_run(here, "a", "1") == stored("a", "1")
