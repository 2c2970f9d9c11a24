from __future__ import annotations

import numpy as np

from intellwheels_experiments.batch.report_drawings import PlottedRun, along, intervals, timeline


def test_runs_of_other_lengths_are_drawn_together() -> None:
    def run(ticks: int) -> PlottedRun:
        times = np.arange(ticks) * 0.05
        true = np.column_stack([times, times, np.zeros(ticks), np.zeros(ticks)])
        return PlottedRun("1", True, true, None, np.ones(ticks), np.ones(ticks), [])

    assert along([run(20), run(60)]).count("<svg") == 1


def test_chair_that_stands_is_drawn_without_a_warning() -> None:
    still = PlottedRun("1", False, np.zeros((5, 4)), None, np.ones(5), np.zeros(5), [])
    assert along([still]).startswith("<svg")


def test_interval_has_the_rows_title() -> None:
    assert "Real/Manual" in intervals([("Real/Manual", 1.0, 0.9, 1.0)])


def test_timeline_names_its_series() -> None:
    drawn = timeline([("leaf", np.arange(3.0), np.arange(3.0))], "deg")
    assert "leaf" in drawn
    assert "simulated time" in drawn
