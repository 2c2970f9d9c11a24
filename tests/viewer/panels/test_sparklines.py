"""The small charts of the proximity sensors."""

from __future__ import annotations

import re

from intellwheels_viewer.panels.sparklines import HEIGHT, WIDTH, sparkline
from intellwheels_viewer.snapshot import Sample


def samples(*values: float | None) -> list[Sample]:
    return [Sample(float(second), 0.0, 0.0, 0.0, 0.0, (value,)) for second, value in enumerate(values)]


def points(chart: str) -> list[tuple[int, int]]:
    return [(int(x), int(y)) for x, y in re.findall(r"(\d+) (\d+)", chart.rpartition('d="')[2])]


def test_far_is_high_and_now_is_right() -> None:
    (before, now) = points(sparkline(samples(0.0, 4.0), 0, 4.0))
    assert now[0] == WIDTH
    assert before[0] < now[0]
    assert (before[1], now[1]) == (HEIGHT - 1, 1)


def test_there_is_no_line_while_nothing_is_seen() -> None:
    chart = sparkline(samples(1.0, 1.0, None, 2.0, 2.0), 0, 4.0)
    assert chart.rpartition('d="')[2].count("M") == 2
    assert not points(sparkline(samples(None, None), 0, 4.0))


def test_there_is_no_chart_of_one_sample_and_none_of_a_sensor_that_is_not_sampled() -> None:
    assert sparkline(samples(1.0), 0, 4.0) == ""
    assert not points(sparkline(samples(1.0, 2.0), 5, 4.0))


def test_half_a_minute_takes_few_bytes() -> None:
    many = [Sample(k / 10, 0.0, 0.0, 0.0, 0.0, (1.0 + k % 3,)) for k in range(300)]
    assert len(points(sparkline(many, 0, 4.0))) <= 62
