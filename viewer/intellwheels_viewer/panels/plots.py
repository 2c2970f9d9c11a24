"""The speed of an agent over the last seconds, as arrays for uPlot, with its newest value at the end of the line.

uPlot has no labels at lines, so the value is HTML over its right margin, positioned with the same scale as the line.
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
from intellwheels_viewer.snapshot import HISTORY, Sample

HEIGHT: Final = 118  # px, the whole plot
_TOP, _RIGHT, _AXIS = 8, 52, 26  # px: padding above, on the right for the value, and below for the time axis
_ABOVE: Final = 11  # px from the plot to its canvas: viser's margin and border
_LABEL: Final = 12  # px, the height of the value
_RATE: Final = 5.0  # samples per second: about one per pixel
STROKE: Final = "#5488b0"
"""Contrast of 3 : 1 or more on white and on viser's dark background: the canvas has no theme."""


@dataclass(frozen=True)
class Plot:
    """A plot: times (n,) in s before now, values (n,), the newest value as text, and the range of the vertical axis."""

    times: npt.NDArray[np.float64]
    values: npt.NDArray[np.float64]
    text: str
    bottom: float
    top: float

    def data(self) -> tuple[npt.NDArray[np.float64], ...]:
        """Return uPlot's data: the times and the line."""
        return (self.times, self.values)

    def series(self) -> tuple[uplot.Series, ...]:
        """Return uPlot's series."""
        return ({}, {"stroke": STROKE, "width": 1.5, "points": {"show": False}})

    def scales(self) -> dict[str, uplot.Scale]:
        """Return uPlot's scales."""
        return {"x": {"time": False, "range": (-HISTORY, 0.0)}, "y": {"range": (self.bottom, self.top)}}


NOTHING: Final = Plot(np.array([-1.0, 0.0]), np.zeros(2), "", 0.0, 1.0)
"""An empty plot."""


def speeds(samples: Sequence[Sample], body: Body | None) -> Plot | None:
    """Return the forward speed; None without two samples."""
    times, kept = _thinned(samples)
    if len(kept) < 2:
        return None
    values = np.array([sample.speed for sample in kept])
    top = max(body.robot.top_speed if body else 0.0, float(np.ceil(values.max() * 2.0) / 2.0), 0.5)
    bottom = min(float(np.floor(values.min() * 2.0 + 1e-6) / 2.0), 0.0)
    return Plot(times, values, number_format.decimal(float(values[-1])), bottom, top)


def label_html(plot: Plot) -> str:
    """Return the newest value at the end of the line."""
    inner = HEIGHT - _TOP - _AXIS
    share = (float(plot.values[-1]) - plot.bottom) / (plot.top - plot.bottom)
    place = _ABOVE + _TOP + (1.0 - min(max(share, 0.0), 1.0)) * inner - _LABEL / 2
    return f'<div class="iw-over"><span class="iw-soft" style="top:{place:.0f}px">{html.escape(plot.text)}</span></div>'


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
