"""The report is self-contained and says what its tables show."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from intellwheels_experiments.batch import report_drawings
from intellwheels_experiments.batch.experiment_rows import Row, rows_of
from intellwheels_experiments.batch.html_report import HtmlReport, floor_hash, render
from intellwheels_experiments.batch.report_drawings import PlottedRun
from intellwheels_experiments.batch.summary import summarize
from intellwheels_maps import floor, scene
from intellwheels_schemas.agent_colours import colour_of, css
from intellwheels_schemas.messages import Compare, Experiment
from tests.experiments.runs import stored

SCENE, FLOOR = scene("table1"), floor("corridor15m")


def run(seed: str, reported: bool = True) -> PlottedRun:
    times = np.arange(50) * 0.05
    true = np.column_stack([times, times * 0.5, np.zeros(50), np.zeros(50)])
    return PlottedRun(
        seed=seed, success=True, true=true, reported=true + np.array([0.0, 0.0, 0.1, 0.0]) if reported else None,
        clearance=np.full(50, 0.5), speed=np.full(50, 0.5), contacts=[(0.5, 0.1)],
    )  # fmt: skip


def page() -> str:
    rows = tuple(Row(name, title, True, SCENE, (), {}) for name, title in (("a", "Real <chair>"), ("b", "Virtual")))
    runs = [stored(row, str(seed), success=row == "b") for row in "ab" for seed in range(3)]
    runs.append(stored("a", "9", died="agent-chair: killed by SIGKILL"))
    experiment = Experiment(subject="chair", compare=(Compare(first="a", second="b", expect="worse"),))
    return render(
        HtmlReport(
            scene=SCENE, floor=FLOOR, summary=summarize(rows, runs, experiment), runs=runs,
            plotted={"a": [run("1"), run("2")]},
            drift={"a": (1e-5, 0.572)}, origin={"floor": floor_hash(FLOOR), "command": "iw-run table1 --seeds 3"},
            timelines={},
        )
    )  # fmt: skip


def test_page_needs_no_network() -> None:
    found = page()
    # Names of XML vocabularies look like addresses, but nothing is loaded from them.
    asked = re.sub(r'xmlns(:\w+)?="[^"]*"|<(rdf|cc|dc):.*|.*</(rdf|cc|dc):.*|<!DOCTYPE svg[^>]*>', "", found)
    assert not re.search(r'(src|href)="(?!#)', asked)
    assert "url(http" not in asked
    assert "<script" not in asked


def test_page_has_rows_comparison_unfinished_runs_and_origin() -> None:
    found = page()
    expected = (
        "Findings",
        "expected to do worse than Virtual",
        "Real &lt;chair&gt;",
        "0 %",
        "100 %",
        "first is worse",
        "undecided",
        "killed by SIGKILL",
    )
    for words in (*expected, floor_hash(FLOOR), "iw-run table1 --seeds 3"):
        assert words in found, words


def whole(name: str, succeeded: Callable[[str], bool]) -> str:
    """Return the page of an included experiment, of one run a row."""
    document = scene(name)
    rows = rows_of(document)
    runs = [stored(row.name, "1", success=succeeded(row.name)) for row in rows]
    return render(
        HtmlReport(
            scene=document, floor=floor(document.map), summary=summarize(rows, runs, document.experiment), runs=runs,
            plotted={row.name: [run("1")] for row in rows[:1]}, drift={}, origin={}, timelines={},
        )
    )  # fmt: skip


def test_sweep_is_a_grid_and_its_many_rows_are_folded() -> None:
    found = whole("door", lambda row: "r60" in row)
    assert found.index("At a glance") < found.index("Row by row")
    assert found.count("<td class=all>1 / 1</td>") == 12
    assert found.count("<td class=none>0 / 1</td>") == 36
    assert "<th>sees 6.0 m<br>opens in 5 s</th>" in found
    assert "<summary>0.5 m/s, opens away, sees 2.0 m, opens in 3 s: 0 / 1</summary>" in found


def test_few_rows_are_not_folded_and_the_goal_is_the_subjects() -> None:
    found = whole("follow", lambda _row: True)
    assert "At a glance" not in found
    assert "<details>" not in found
    assert "<th>Leader&#x27;s messages</th>" in found
    # No row has a user, so there is no effort to show.
    assert "effort" not in found
    goal = next(one for one in floor("corner").grid.position if one.name == "goal1")  # type: ignore[union-attr]
    colour = css(colour_of("follower1"))
    assert report_drawings.paths(floor("corner"), [run("1")], (goal.x, goal.y, 0.3), colour) in found


def test_drawing_scales_with_the_page_and_is_reproducible() -> None:
    drawn = report_drawings.paths(FLOOR, [run("1")], (15.0, 0.0, 0.5))
    assert drawn.startswith("<svg")
    assert 'width="100%"' in drawn[:400]
    assert drawn == report_drawings.paths(FLOOR, [run("1")], (15.0, 0.0, 0.5))


def test_drift_is_drawn_if_poses_were_reported() -> None:
    assert report_drawings.drift([run("1", reported=False)], 1e-5, 0.5) is None
    drawn = report_drawings.drift([run("1")], 1e-5, 0.5)
    assert drawn is not None
    assert "95 % of wheel noise alone" in drawn
