"""Sentences claim what the runs tell, and no more."""

from __future__ import annotations

from typing import Literal

import msgspec
import pytest

from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.findings import sentences
from intellwheels_experiments.batch.run_store import StoredRun
from intellwheels_experiments.batch.summary import sum_up
from intellwheels_maps import scene
from intellwheels_schemas.messages import Compare, Experiment
from tests.experiments.runs import kept

SCENE = scene("table1")
ROWS = tuple(Row(name, title, False, SCENE, (), {}) for name, title in (("good", "The good"), ("bad", "The bad")))


def said(runs: list[StoredRun], asked: Compare) -> str:
    (found,) = sentences(sum_up(ROWS, runs, Experiment(subject="chair", compare=(asked,))))
    return found


def forty(failures: int, **more: float) -> list[StoredRun]:
    runs = [kept("good", str(seed)) for seed in range(40)]
    for seed in range(40):
        bad = kept("bad", str(seed), success=seed >= failures)
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
            "The bad was expected to be worse than The good, and it was: 26 of 40 succeeded against 40 of 40.",
        ),
        (14, "better", "The bad was expected to be better than The good. It was not: 26 of 40"),
        (4, "worse", "By success these runs do not tell: 36 of 40 succeeded against 40 of 40."),
        (0, "worse", "It was not: 40 of 40 succeeded against 40 of 40, which is as good within the margin."),
        (0, "equivalent", "The bad was expected to be as good as The good, and it was"),
        (6, None, "The bad beside The good: 34 of 40 succeeded against 40 of 40."),
    ],
)
def test_a_comparison_says_what_was_expected_and_what_came(
    failures: int, expect: Literal["worse", "better", "equivalent"] | None, words: str
) -> None:
    assert words in said(forty(failures), Compare(first="bad", second="good", expect=expect))


def test_a_row_alone_says_what_it_touched() -> None:
    assert said(forty(3), Compare(first="good", expect="collision-free")) == (
        "The good touched nothing in 40 runs, as expected."
    )
    assert "It touched something in 3 of 40 runs." in said(forty(3), Compare(first="bad", expect="collision-free"))


def test_what_success_does_not_tell_other_measures_may() -> None:
    words = said(forty(0, clearance=-0.0105, path=0.1495), Compare(first="bad", second="good", expect="worse"))
    assert words.endswith(
        "Where both reached their place, the first came 1.0 cm (1.0 to 1.0) nearer to something "
        "and drove 15 cm (15 to 15) further."
    )


def test_a_difference_whose_interval_has_zero_in_it_is_not_told() -> None:
    assert "Where both" not in said(forty(0), Compare(first="bad", second="good"))
