from __future__ import annotations

from xml.etree import ElementTree as Tree

import msgspec
import pytest

from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.run_store import StoredRun
from intellwheels_experiments.batch.statistics import wilson
from intellwheels_experiments.batch.summary import Summary, summarize, to_json, to_junit
from intellwheels_maps import scene
from intellwheels_schemas.messages import Compare, Experiment
from tests.experiments.runs import stored

SCENE = scene("table1")
ROWS = tuple(Row(name, name.upper(), False, SCENE, (), {}) for name in ("good", "bad"))


def summary_of(runs: list[StoredRun], *compared: Compare) -> Summary:
    return summarize(ROWS, runs, Experiment(subject="chair", compare=compared))


def forty(failures: int) -> list[StoredRun]:
    good = [stored("good", str(seed)) for seed in range(40)]
    return good + [stored("bad", str(seed), success=seed >= failures) for seed in range(40)]


def test_row_counts_finished_runs_and_names_the_others() -> None:
    row = summary_of([*forty(14), stored("bad", "x", died="server: exit 1")]).lines[1]
    assert (row.runs, row.succeeded, row.collided, row.physical, row.died) == (40, 26, 14, 28, ("x",))
    assert row.interval == wilson(26, 40)
    assert row.spread["time"].median == 25.0
    assert "effort" not in row.spread


@pytest.mark.parametrize(
    ("failures", "expect", "verdict"),
    [
        (14, "worse", "as expected"), (14, "better", "otherwise"), (4, "worse", "undecided"), (0, "worse", "otherwise"),
        (0, "equivalent", "as expected"), (3, "equivalent", "undecided"), (30, "equivalent", "otherwise"),
    ],
)  # fmt: skip
def test_verdict_follows_from_the_pairs(failures: int, expect: str, verdict: str) -> None:
    asked = Compare(first="bad", second="good", expect=expect)  # type: ignore[arg-type]
    assert summary_of(forty(failures), asked).comparisons[0].verdict == verdict


def test_single_row_is_expected_to_touch_nothing() -> None:
    asked = [Compare(first=name, expect="collision-free") for name in ("good", "bad")]
    assert [one.verdict for one in summary_of(forty(1), *asked).comparisons] == ["as expected", "otherwise"]


def test_rows_are_paired_by_seed_even_if_runs_are_missing() -> None:
    runs = [run for run in forty(0) if not (run.row == "good" and run.seed in ("3", "5"))]
    paired = summary_of(runs, Compare(first="bad", second="good")).comparisons[0].paired
    assert paired is not None
    assert paired.pairs == 38


@pytest.mark.parametrize("lacking", ["good", "bad"])
def test_rows_of_which_runs_were_not_made_are_not_judged(lacking: str) -> None:
    runs = [*forty(30), StoredRun(row=lacking, seed="x")]
    asked = (Compare(first="bad", second="good", expect="worse"), Compare(first="good", expect="collision-free"))
    summary = summary_of(runs, *asked)
    assert [len(row.missing) for row in summary.lines] == [int(lacking == "good"), int(lacking == "bad")]
    assert not any(row.died for row in summary.lines)
    alone = "incomplete" if lacking == "good" else "as expected"
    assert [one.verdict for one in summary.comparisons] == ["incomplete", alone]
    assert summary.comparisons[0].paired is None
    root = Tree.fromstring(to_junit("e", summary, runs))
    assert [suite.get("skipped") for suite in root][:2] == [str(len(row.missing)) for row in summary.lines]
    assert not list(root.iter("error"))
    assert not list(root.iter("failure"))
    assert "it was not run" in [skipped.get("message") for skipped in root.iter("skipped")]


def test_measures_are_compared_over_the_seeds_that_both_reached_their_place_with() -> None:
    runs = [*forty(0), stored("good", "x"), stored("bad", "x")]
    changed = {"clearance": 0.1, "reached": False}
    last = runs[-1].measured
    assert last is not None
    runs[-1] = msgspec.structs.replace(runs[-1], measured=msgspec.structs.replace(last, **changed))
    differences = summary_of(runs, Compare(first="bad", second="good")).comparisons[0].differences
    assert differences["clearance"] == (0.0, (0.0, 0.0))
    assert set(differences) == {"clearance", "time", "path", "odometry_error"}


def test_comparison_with_a_row_that_was_not_run_is_left_out() -> None:
    assert summary_of(forty(0), Compare(first="bad", second="ugly")).comparisons == ()


def test_rows_without_a_common_seed_have_no_verdict_without_an_expectation() -> None:
    runs = [stored("good", "1"), stored("bad", "2")]
    summary = summary_of(runs, Compare(first="bad", second="good"))
    assert summary.comparisons[0].verdict == "not asked"
    assert 'skipped="0"' in to_junit("e", summary, runs)


def test_junit_is_xml_whatever_a_process_printed() -> None:
    runs = [stored("good", "1"), stored("bad", "1", died="agent-chair: \x1b[31mred\x00\ud800")]
    assert "red" in str(next(Tree.fromstring(to_junit("e", summary_of(runs), runs)).iter("error")).text)


def test_junit_has_an_error_for_a_dead_run_and_a_failure_for_a_wrong_expectation() -> None:
    runs = [*forty(30), stored("good", "x", died="agent-chair: exit 3\n  words")]
    summary = summary_of(runs, Compare(first="bad", second="good", expect="equivalent"))
    root = Tree.fromstring(to_junit("e", summary, runs))
    assert [error.get("message") for error in root.iter("error")] == ["agent-chair: exit 3"]
    assert len(list(root.iter("failure"))) == 1
    assert to_json(summary).startswith(b"{")
