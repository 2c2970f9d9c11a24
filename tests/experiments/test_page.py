"""The page stands alone and says what is to be read off it."""

from __future__ import annotations

import re

import numpy as np

from intellwheels_experiments import drawings
from intellwheels_experiments.drawings import Drawn
from intellwheels_experiments.page import Page, floor_hash, render
from intellwheels_experiments.rows import Row
from intellwheels_experiments.summary import sum_up
from intellwheels_maps import floor, scene
from intellwheels_schemas.messages import Compare, Experiment
from tests.experiments.runs import kept

SCENE, FLOOR = scene("table1"), floor("corridor15m")


def run(seed: str, reported: bool = True) -> Drawn:
    times = np.arange(50) * 0.05
    true = np.column_stack([times, times * 0.5, np.zeros(50), np.zeros(50)])
    return Drawn(
        seed=seed, success=True, true=true, reported=true + np.array([0.0, 0.0, 0.1, 0.0]) if reported else None,
        clearance=np.full(50, 0.5), speed=np.full(50, 0.5), contacts=[(0.5, 0.1)],
    )  # fmt: skip


def page() -> str:
    rows = tuple(Row(name, title, True, SCENE, (), {}) for name, title in (("a", "Real <chair>"), ("b", "Virtual")))
    runs = [kept(row, str(seed), success=row == "b") for row in "ab" for seed in range(3)]
    runs.append(kept("a", "9", died="agent-chair: killed by SIGKILL"))
    experiment = Experiment(subject="chair", compare=(Compare(first="a", second="b", expect="worse"),))
    return render(
        Page(
            scene=SCENE, floor=FLOOR, summary=sum_up(rows, runs, experiment), runs=runs,
            drawn={"a": [run("1"), run("2")]},
            drift={"a": (1e-5, 0.572)}, origin={"floor": floor_hash(FLOOR), "command": "iw-run table1 --seeds 3"},
            timelines={},
        )
    )  # fmt: skip


def test_page_asks_no_network_for_anything() -> None:
    found = page()
    # Names of XML vocabularies look like addresses and are never asked for.
    asked = re.sub(r'xmlns(:\w+)?="[^"]*"|<(rdf|cc|dc):.*|.*</(rdf|cc|dc):.*|<!DOCTYPE svg[^>]*>', "", found)
    assert not re.search(r'(src|href)="(?!#)', asked)
    assert "url(http" not in asked
    assert "<script" not in asked


def test_page_says_rows_comparison_who_died_and_where_it_comes_from() -> None:
    found = page()
    expected = (
        "What these runs say",
        "expected to be worse than Virtual",
        "Real &lt;chair&gt;",
        "0 %",
        "100 %",
        "it is worse",
        "undecided",
        "killed by SIGKILL",
    )
    for words in (*expected, floor_hash(FLOOR), "iw-run table1 --seeds 3"):
        assert words in found, words


def test_drawing_scales_with_the_page_and_is_the_same_again() -> None:
    drawn = drawings.paths(FLOOR, [run("1")], (15.0, 0.0, 0.5))
    assert drawn.startswith("<svg")
    assert 'width="100%"' in drawn[:400]
    assert drawn == drawings.paths(FLOOR, [run("1")], (15.0, 0.0, 0.5))


def test_drift_is_drawn_where_something_is_reported() -> None:
    assert drawings.drift([run("1", reported=False)], 1e-5, 0.5) is None
    drawn = drawings.drift([run("1")], 1e-5, 0.5)
    assert drawn is not None
    assert "95 % of wheel noise alone" in drawn
