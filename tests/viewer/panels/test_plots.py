"""What is plotted, and where its labels stand."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest

from intellwheels_viewer.panels import plots
from intellwheels_viewer.snapshot import Sample
from tests.viewer.panels import made_up

BODY = made_up.snapshot().bodies["chair1"]
HISTORY = made_up.snapshot().history["chair1"]


def sample(time: float, *ranges: float | None, speed: float = 0.0) -> Sample:
    return Sample(time, 0.0, 0.0, 0.0, speed, ranges)


def test_times_end_at_now_and_are_thinned() -> None:
    plot = plots.speeds(HISTORY, BODY)
    assert plot is not None
    assert plot.times[0] == pytest.approx(-30.0)
    assert plot.times[-1] == 0.0
    assert 150 <= len(plot.times) <= 152


def test_another_agent_is_other_data_of_the_same_shape() -> None:
    few = plots.distances([sample(0, 1.0), sample(1, 2.0)], BODY)
    many = plots.distances(HISTORY, BODY)
    assert few is not None
    assert many is not None
    assert len(few.data()) == len(many.data()) == len(few.series()) == plots.LINES + 1


def test_what_sees_nothing_leaves_the_picture() -> None:
    plot = plots.distances([sample(0, 1.0), sample(1, None)], BODY)
    assert plot is not None
    assert plot.lines[0].values[-1] > plot.top
    assert plot.lines[0].text == "\u2013"


def test_a_line_has_the_tone_of_its_newest_value() -> None:
    plot = plots.distances([sample(0, 2.0, 2.0, 2.0), sample(1, 0.2, 1.0, 2.5)], BODY)
    assert plot is not None
    assert [line.tone for line in plot.lines[:3]] == ["near", "middle", "far"]
    assert plot.series()[1]["stroke"] == plots.STROKES["near"]


def test_there_is_no_plot_of_one_sample_or_without_a_sensor() -> None:
    assert plots.distances([sample(0, 1.0)], BODY) is None
    assert plots.distances(HISTORY, made_up.snapshot().bodies["table1"]) is None
    assert plots.speeds([], None) is None


def test_backward_speed_is_below_the_axis() -> None:
    plot = plots.speeds([sample(0, speed=0.2), sample(1, speed=-0.3)], None)
    assert plot is not None
    assert (plot.bottom, plot.top) == (-0.5, 0.5)


def test_labels_stand_at_the_ends_of_their_lines() -> None:
    plot = plots.Plot(
        np.array([-1.0, 0.0]),
        (plots.Line("top", "3.00", "far", np.array([0.0, 3.0])), plots.Line("low", "0.00", "near", np.zeros(2))),
        0.0,
        3.0,
    )
    tops = [int(top) for top in re.findall(r"top:(\d+)px", plots.labels_html(plot))]
    assert tops[0] < 20
    assert plots.HEIGHT - 40 < tops[1] < plots.HEIGHT


def test_labels_do_not_cover_each_other() -> None:
    places = plots.apart([50.0, 50.0, 51.0, 200.0, 0.0], 12, 10, 100)
    ordered = sorted(places)
    assert all(b - a >= 12 for a, b in itertools.pairwise(ordered))
    assert ordered[0] >= 10
    assert ordered[-1] <= 100


def test_labels_that_do_not_fit_still_do_not_cover_each_other() -> None:
    places = sorted(plots.apart([0.0] * 20, 12, 0, 100))
    assert all(b - a >= 12 for a, b in itertools.pairwise(places))


def test_a_sensor_with_a_strange_name_is_text() -> None:
    plot = plots.Plot(np.array([-1.0, 0.0]), (plots.Line("<img>", "1", "", np.ones(2)),), 0.0, 3.0)
    assert "<img>" not in plots.labels_html(plot)
