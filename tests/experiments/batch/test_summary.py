from __future__ import annotations

from xml.etree import ElementTree as Tree

import msgspec
import pytest

from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.run_store import StoredRun
from intellwheels_experiments.batch.statistics import wilson
from intellwheels_experiments.batch.summary import Summary, sum_up, to_json, to_junit
from intellwheels_maps import scene
from intellwheels_schemas.messages import Compare, Experiment
from tests.experiments.runs import kept

SCENE = scene("table1")
ROWS = tuple(Row(name, name.upper(), False, SCENE, (), {}) for name in ("good", "bad"))


def summed(runs: list[StoredRun], *asked: Compare) -> Summary:
    return sum_up(ROWS, runs, Experiment(subject="chair", compare=asked))


def forty(failures: int) -> list[StoredRun]:
    good = [kept("good", str(seed)) for seed in range(40)]
    return good + [kept("bad", str(seed), success=seed >= failures) for seed in range(40)]


def test_row_counts_what_came_to_an_end_and_names_what_did_not() -> None:
    line = summed([*forty(14), kept("bad", "x", died="server: exit 1")]).lines[1]
    assert (line.runs, line.succeeded, line.collided, line.physical, line.died) == (40, 26, 14, 28, ("x",))
    assert line.interval == wilson(26, 40)
    assert line.spread["time"].median == 25.0
    assert "effort" not in line.spread


@pytest.mark.parametrize(
    ("failures", "expect", "verdict"),
    [
        (14, "worse", "as expected"), (14, "better", "otherwise"), (4, "worse", "undecided"), (0, "worse", "otherwise"),
        (0, "equivalent", "as expected"), (3, "equivalent", "undecided"), (30, "equivalent", "otherwise"),
    ],
)  # fmt: skip
def test_verdict_is_what_the_pairs_can_tell(failures: int, expect: str, verdict: str) -> None:
    asked = Compare(first="bad", second="good", expect=expect)  # type: ignore[arg-type]
    assert summed(forty(failures), asked).comparisons[0].verdict == verdict


def test_row_alone_is_expected_to_touch_nothing() -> None:
    asked = [Compare(first=name, expect="collision-free") for name in ("good", "bad")]
    assert [one.verdict for one in summed(forty(1), *asked).comparisons] == ["as expected", "otherwise"]


def test_rows_are_paired_by_seed_whatever_died() -> None:
    runs = [run for run in forty(0) if not (run.row == "good" and run.seed in ("3", "5"))]
    paired = summed(runs, Compare(first="bad", second="good")).comparisons[0].paired
    assert paired is not None
    assert paired.pairs == 38


def test_measures_are_compared_over_the_seeds_that_both_reached_their_place_with() -> None:
    runs = [*forty(0), kept("good", "x"), kept("bad", "x")]
    changed = {"clearance": 0.1, "reached": False}
    last = runs[-1].measured
    assert last is not None
    runs[-1] = msgspec.structs.replace(runs[-1], measured=msgspec.structs.replace(last, **changed))
    differences = summed(runs, Compare(first="bad", second="good")).comparisons[0].differences
    assert differences["clearance"] == (0.0, (0.0, 0.0))
    assert set(differences) == {"clearance", "time", "path", "odometry_error"}


def test_comparison_with_a_row_that_is_not_run_is_left_out() -> None:
    assert summed(forty(0), Compare(first="bad", second="ugly")).comparisons == ()


def test_rows_without_a_common_seed_say_nothing_where_nothing_is_asked() -> None:
    runs = [kept("good", "1"), kept("bad", "2")]
    summary = summed(runs, Compare(first="bad", second="good"))
    assert summary.comparisons[0].verdict == "not asked"
    assert 'skipped="0"' in to_junit("e", summary, runs)


def test_junit_is_xml_whatever_a_process_printed() -> None:
    runs = [kept("good", "1"), kept("bad", "1", died="agent-chair: \x1b[31mred\x00\ud800")]
    assert "red" in str(next(Tree.fromstring(to_junit("e", summed(runs), runs)).iter("error")).text)


def test_junit_has_an_error_for_who_died_and_a_failure_for_what_is_otherwise() -> None:
    runs = [*forty(30), kept("good", "x", died="agent-chair: exit 3\n  words")]
    summary = summed(runs, Compare(first="bad", second="good", expect="equivalent"))
    root = Tree.fromstring(to_junit("e", summary, runs))
    assert [error.get("message") for error in root.iter("error")] == ["agent-chair: exit 3"]
    assert len(list(root.iter("failure"))) == 1
    assert to_json(summary).startswith(b"{")
