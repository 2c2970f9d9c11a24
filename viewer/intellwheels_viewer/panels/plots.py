"""Distances and speed of an agent over the last seconds, as arrays for uPlot, with a label at the end of each line.

uPlot has no labels at lines, so they are HTML over its right margin, positioned with the same scale as the lines.
"""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from viser import uplot

from intellwheels_schemas.messages import Body
from intellwheels_viewer.panels import number_format
from intellwheels_viewer.panels.ranges import tone
from intellwheels_viewer.snapshot import HISTORY, Sample

LINES: Final = 8
"""Lines of a plot. The number is fixed, so another agent only changes the data; more could not be told apart."""
HEIGHT: Final = 138  # px, the whole plot
_TOP, _RIGHT, _AXIS = 8, 90, 26  # px: padding above, on the right for labels, and below for the time axis
_ABOVE: Final = 11  # px from the plot to its canvas: viser's margin and border
_LABEL: Final = 12  # px, the height of a label
_RATE: Final = 5.0  # samples per second: about one per pixel
# Contrast of 3 : 1 or more on white and on viser's dark background: the canvas has no theme.
STROKES: Final = {"near": "#d23a6b", "middle": "#c2701a", "far": "#5488b0", "": "#5488b0"}


@dataclass(frozen=True)
class Line:
    """A line: its label, its newest value as text, its tone and its values. A missing value is above `top`."""

    label: str
    text: str
    tone: str
    values: npt.NDArray[np.float64]


@dataclass(frozen=True)
class Plot:
    """A plot: times (n,) in s before now, the lines, and the range of the vertical axis."""

    times: npt.NDArray[np.float64]
    lines: tuple[Line, ...]
    bottom: float
    top: float

    def data(self) -> tuple[npt.NDArray[np.float64], ...]:
        """Return uPlot's data: the times and `LINES` lines. Unused lines are outside the picture."""
        outside = np.full_like(self.times, 2.0 * self.top)
        values = [line.values for line in self.lines]
        return (self.times, *values, *[outside] * (LINES - len(values)))

    def series(self) -> tuple[uplot.Series, ...]:
        """Return uPlot's series, coloured by the tones of the newest values."""
        strokes = [STROKES[line.tone] for line in self.lines]
        strokes += [STROKES[""]] * (LINES - len(strokes))
        return ({}, *(_series(stroke) for stroke in strokes))

    def scales(self) -> dict[str, uplot.Scale]:
        """Return uPlot's scales."""
        return {"x": {"time": False, "range": (-HISTORY, 0.0)}, "y": {"range": (self.bottom, self.top)}}


NOTHING: Final = Plot(np.array([-1.0, 0.0]), (), 0.0, 1.0)
"""An empty plot."""


def distances(samples: Sequence[Sample], body: Body | None) -> Plot | None:
    """Return the distances of the proximity sensors; None without two samples or without a sensor.

    With more than `LINES` sensors the nearest ones are shown. The line of a sensor that sees nothing is outside the
    plot.
    """
    times, kept = _thinned(samples)
    sensors = [(one.id, one.max_range) for one in body.robot.proximity] if body else []
    if len(kept) < 2 or not sensors:
        return None
    top = max(most for _, most in sensors)
    columns = [[_range(sample, index) for sample in kept] for index in range(len(sensors))]
    order = sorted(range(len(sensors)), key=lambda index: (_last(columns[index]), index))[:LINES]
    lines = (_distance(sensors[index][0], columns[index], top) for index in sorted(order))
    return Plot(times, tuple(lines), 0.0, top)


def speeds(samples: Sequence[Sample], body: Body | None) -> Plot | None:
    """Return the forward speed; None without two samples."""
    times, kept = _thinned(samples)
    if len(kept) < 2:
        return None
    values = np.array([sample.speed for sample in kept])
    top = max(body.robot.top_speed if body else 0.0, float(np.ceil(values.max() * 2.0) / 2.0), 0.5)
    bottom = min(float(np.floor(values.min() * 2.0 + 1e-6) / 2.0), 0.0)
    return Plot(times, (Line("", number_format.decimal(float(values[-1])), "", values),), bottom, top)


def labels_html(plot: Plot) -> str:
    """Return the labels at the ends of the lines, moved apart so that they do not overlap."""
    inner = HEIGHT - _TOP - _AXIS
    wanted = [_ABOVE + _TOP + (1.0 - _share(line, plot)) * inner - _LABEL / 2 for line in plot.lines]
    lowest = float(_ABOVE + _TOP + inner - _LABEL)
    spans = (
        f'<span class="iw-{line.tone or "soft"}" style="top:{place:.0f}px">{html.escape(line.text)} '
        f"{html.escape(line.label)}</span>"
        for line, place in zip(plot.lines, apart(wanted, _LABEL, _ABOVE, lowest), strict=True)
    )
    return f'<div class="iw-over">{"".join(spans)}</div>'


def apart(wanted: Sequence[float], size: float, least: float, most: float) -> list[float]:
    """Return positions near the wanted ones, at least `size` apart, and within the bounds if they all fit."""
    order = sorted(range(len(wanted)), key=lambda index: wanted[index])
    places = list(wanted)
    floor = least
    for index in order:
        places[index] = floor = max(places[index], floor)
        floor += size
    ceiling = max(most, least + size * (len(wanted) - 1))
    for index in reversed(order):
        places[index] = ceiling = min(places[index], ceiling)
        ceiling -= size
    return places


def axes() -> tuple[Any, ...]:
    """Return uPlot's axes: 11 px figures, time in s before now, at most five values."""
    font = "11px system-ui, sans-serif"
    return (
        {"font": font, "size": _AXIS, "gap": 8, "space": 40, "ticks": {"show": False}},
        {"font": font, "size": 34, "space": 26, "ticks": {"show": False}},
    )


def padding() -> tuple[int, int, int, int]:
    """Return uPlot's padding in px: top, right, bottom, left."""
    return _TOP, _RIGHT, 0, 0


def _thinned(samples: Sequence[Sample]) -> tuple[npt.NDArray[np.float64], list[Sample]]:
    """Return the first sample of each fifth of a second and the newest, and their times relative to the newest."""
    kept: list[Sample] = []
    for sample in samples:
        if not kept or int(sample.time * _RATE) != int(kept[-1].time * _RATE):
            kept.append(sample)
    if kept and kept[-1] is not samples[-1]:
        kept.append(samples[-1])
    now = kept[-1].time if kept else 0.0
    return np.array([sample.time - now for sample in kept]), kept


def _range(sample: Sample, index: int) -> float | None:
    return sample.ranges[index] if index < len(sample.ranges) else None


def _last(column: Sequence[float | None]) -> float:
    return np.inf if column[-1] is None else column[-1]


def _distance(sensor: str, column: Sequence[float | None], top: float) -> Line:
    newest = column[-1]
    values = np.array([2.0 * top if value is None else value for value in column])
    if newest is None:
        return Line(sensor, "\u2013", "far", values)
    return Line(sensor, number_format.decimal(newest), tone(newest), values)


def _share(line: Line, plot: Plot) -> float:
    share = (float(line.values[-1]) - plot.bottom) / (plot.top - plot.bottom)
    return min(max(share, 0.0), 1.0)


def _series(stroke: str) -> uplot.Series:
    return {"stroke": stroke, "width": 1.5, "points": {"show": False}}
