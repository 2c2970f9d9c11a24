"""Sentences claim what the runs show, and no more."""

from __future__ import annotations

from typing import Literal

import msgspec
import pytest

from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.findings import counted, sentences
from intellwheels_experiments.batch.run_store import StoredRun
from intellwheels_experiments.batch.summary import summarize
from intellwheels_maps import scene
from intellwheels_schemas.messages import Compare, Experiment
from tests.experiments.runs import stored

SCENE = scene("table1")
ROWS = tuple(Row(name, title, False, SCENE, (), {}) for name, title in (("good", "The good"), ("bad", "The bad")))


def sentence(runs: list[StoredRun], asked: Compare) -> str:
    (found,) = sentences(summarize(ROWS, runs, Experiment(subject="chair", compare=(asked,))))
    return found


def forty(failures: int, **more: float) -> list[StoredRun]:
    runs = [stored("good", str(seed)) for seed in range(40)]
    for seed in range(40):
        bad = stored("bad", str(seed), success=seed >= failures)
        assert bad.measured is not None
        changes = {name: getattr(bad.measured, name) + by + seed % 2 * 1e-3 for name, by in more.items()}
        runs.append(msgspec.structs.replace(bad, measured=msgspec.structs.replace(bad.measured, **changes)))
    return runs


@pytest.mark.parametrize(
    ("failures", "expect", "words"),
    [
        (
            14,
            "worse",
            "The bad was expected to do worse than The good, and it did: 26 of 40 runs succeeded, against 40 of 40.",
        ),
        (14, "better", "The bad was expected to do better than The good, but it did not: 26 of 40"),
        (4, "worse", "The success rates do not settle it: 36 of 40 runs succeeded, against 40 of 40."),
        (0, "worse", "40 of 40 runs succeeded, against 40 of 40. The two are equivalent within the margin."),
        (0, "equivalent", "The bad was expected to do as well as The good, and it did"),
        (6, None, "The bad compared with The good: 34 of 40 runs succeeded, against 40 of 40."),
    ],
)
def test_comparison_states_the_expectation_and_the_result(
    failures: int, expect: Literal["worse", "better", "equivalent"] | None, words: str
) -> None:
    assert words in sentence(forty(failures), Compare(first="bad", second="good", expect=expect))


def test_rows_of_which_runs_were_not_made_are_not_judged() -> None:
    runs = [*forty(3), StoredRun(row="bad", seed="x"), StoredRun(row="bad", seed="y")]
    asked = Compare(first="bad", second="good", expect="worse")
    assert sentence(runs, asked) == "The bad is not compared with The good: 2 runs of The bad were not done."
    runs = [*forty(3), StoredRun(row="good", seed="x")]
    asked = Compare(first="good", expect="collision-free")
    assert sentence(runs, asked) == "The good is not judged: 1 run of The good was not done."


def test_single_row_states_what_it_touched() -> None:
    assert sentence(forty(3), Compare(first="good", expect="collision-free")) == (
        "The good touched nothing in 40 runs, as expected."
    )
    assert "but it did in 3 of 40 runs." in sentence(forty(3), Compare(first="bad", expect="collision-free"))


def test_other_measures_may_differ_where_success_does_not() -> None:
    words = sentence(forty(0, clearance=-0.0105, path=0.1495), Compare(first="bad", second="good", expect="worse"))
    assert words.endswith(
        "In the runs in which both reached their place, the first kept 1.0 cm (1.0 to 1.0) less clearance "
        "and drove 15 cm (15 to 15) further."
    )


def test_difference_whose_interval_contains_zero_is_not_mentioned() -> None:
    assert "In the runs" not in sentence(forty(0), Compare(first="bad", second="good"))


def test_two_single_runs_are_compared_in_time_path_and_clearance() -> None:
    one, other = stored("good", "1"), stored("bad", "1")
    assert one.measured is not None
    assert other.measured is not None
    changes = {"time": one.measured.time + 3.5, "path": one.measured.path - 0.25, "clearance": one.measured.clearance}
    other = msgspec.structs.replace(other, measured=msgspec.structs.replace(other.measured, **changes))
    before = one.measured
    assert before.clearance is not None
    assert sentence([one, other], Compare(first="bad", second="good")) == (
        "First run: The bad. Second run: The good. Both runs reached the place and touched nothing. "
        f"The first run took 3.50 s longer ({before.time + 3.5:.2f} s, not {before.time:.2f} s), "
        f"drove 0.25 m less ({before.path - 0.25:.2f} m, not {before.path:.2f} m) "
        f"and kept as much clearance ({100 * before.clearance:.1f} cm)."
    )


def test_two_single_runs_that_came_to_something_else_say_so() -> None:
    found = sentence([stored("good", "1"), stored("bad", "1", success=False)], Compare(first="bad", second="good"))
    assert "but the second one reached the place and touched nothing." in found


@pytest.mark.parametrize(("number", "words"), [(0, "0 runs"), (1, "1 run"), (2, "2 runs")])
def test_a_noun_is_in_the_plural_unless_there_is_one(number: int, words: str) -> None:
    assert counted(number, "run") == words
    if number:
        runs = [stored("good", str(seed)) for seed in range(number)]
        assert f"touched nothing in {words}, as expected" in sentence(
            runs, Compare(first="good", expect="collision-free")
        )
