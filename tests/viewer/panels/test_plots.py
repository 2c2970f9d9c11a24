"""What is plotted, and where its newest value stands."""

from __future__ import annotations

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


def test_there_is_no_plot_of_one_sample() -> None:
    assert plots.speeds([sample(0)], BODY) is None
    assert plots.speeds([], None) is None


def test_backward_speed_is_below_the_axis() -> None:
    plot = plots.speeds([sample(0, speed=0.2), sample(1, speed=-0.3)], None)
    assert plot is not None
    assert (plot.bottom, plot.top) == (-0.5, 0.5)


def test_the_newest_value_stands_at_the_end_of_the_line() -> None:
    high = plots.Plot(np.array([-1.0, 0.0]), np.array([0.0, 3.0]), "3.00", 0.0, 3.0)
    low = plots.Plot(np.array([-1.0, 0.0]), np.zeros(2), "0.00", 0.0, 3.0)
    tops = [int(re.findall(r"top:(\d+)px", plots.label_html(plot))[0]) for plot in (high, low)]
    assert tops[0] < 20
    assert plots.HEIGHT - 40 < tops[1] < plots.HEIGHT
