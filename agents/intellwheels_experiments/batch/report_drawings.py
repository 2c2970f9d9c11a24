"""The report's drawings as SVG text that can stand in a page. They use matplotlib and no network.

The colours are Okabe and Ito's, which people with colour blindness can tell apart. True paths are solid and reported
paths are dashed, so no meaning rests on colour alone.
"""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from intellwheels_experiments.batch.metrics import Floats, drift_band
from intellwheels_maps.check import wall_pieces
from intellwheels_schemas.messages import Map

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TRUE, REPORTED, CONTACT, WALL = "#0072B2", "#D55E00", "#CC0033", "#9a9a94"
WIDTH: Final = 9.6
"""Inches, for a page of 960 px."""
STYLE: Final[Any] = {"svg.fonttype": "none", "svg.hashsalt": "iw", "font.family": "sans-serif", "font.size": 9.0,
                "axes.spines.top": False, "axes.spines.right": False}  # fmt: skip
GRID: Final = 400
"""Points along the path at which clearance and speed are drawn."""
EVERY: Final = 4
"""Only every fourth tick of a path is drawn: five points a second at 20 Hz, which keeps a page of forty runs small."""


@dataclass(frozen=True)
class PlottedRun:
    """A run to draw.

    Attributes:
        seed: Its seed.
        success: Whether it succeeded.
        true: The true trajectory, float64[n, 4]: t in s, x and y in m, heading in rad.
        reported: The reported trajectory, in the same form, or None.
        clearance: Distance from the nearest thing, float64[n], in m.
        speed: float64[n], in m/s.
        contacts: x and y of each contact, in m.
    """

    seed: str
    success: bool
    true: Floats
    reported: Floats | None
    clearance: Floats
    speed: Floats
    contacts: Sequence[tuple[float, float]]

    @property
    def distance(self) -> Floats:
        """The distance driven until each tick, float64[n], in m."""
        return np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(self.true[:, 1]), np.diff(self.true[:, 2])))])


def paths(floor: Map, runs: Sequence[PlottedRun], goal: tuple[float, float, float] | None, colour: str = TRUE) -> str:
    """Return the paths of runs on a map.

    Args:
        floor: The map.
        runs: The runs.
        goal: x, y and the radius of the place to reach, m; None for no goal.
        colour: The colour of the body, see `agent_colours`.
    """
    corners = np.array([(c.x, c.y) for wall in floor.wall for c in wall.corner])
    (left, low), (right, high) = corners.min(axis=0) - 0.15, corners.max(axis=0) + 0.15
    height = min(6.0, (WIDTH - 0.7) * (high - low) / (right - left)) + 0.55
    with _style():
        figure, axes = _plot(height)
        _draw_floor(axes, floor)
        if goal is not None:
            from matplotlib.patches import Circle  # noqa: PLC0415

            axes.add_patch(Circle(goal[:2], goal[2], fill=False, ec="#009E73", lw=1.2))
        for run in runs:
            axes.plot(*run.true[::EVERY, 1:3].T, color=colour, lw=0.8, alpha=_opacity(runs))
            if run.reported is not None:
                axes.plot(*run.reported[::EVERY, 1:3].T, color=REPORTED, lw=0.7, ls=(0, (4, 2)), alpha=_opacity(runs))
        contacts = [position for run in runs for position in run.contacts]
        if contacts:
            axes.plot(*zip(*contacts, strict=True), "x", color=CONTACT, ms=6, mew=1.6)
        axes.set(xlim=(left, right), ylim=(low, high), aspect="equal", xlabel="x (m)", ylabel="y (m)")
        return _svg(figure)


def along(runs: Sequence[PlottedRun]) -> str:
    """Return clearance and speed over the distance driven: the median of the runs and the middle 80 % of them."""
    longest = max(0.1, *(float(run.distance[-1]) for run in runs))
    grid = np.linspace(0.0, longest, GRID)
    with _style():
        figure, (upper, lower) = _plot(2.6, 2)
        for axes, name, colour in ((upper, "clearance", "#009E73"), (lower, "speed", TRUE)):
            values = np.array([_resampled(grid, run.distance, getattr(run, name)) for run in runs])
            present = ~np.isnan(values).all(axis=0)
            low, median, high = np.full((3, GRID), np.nan)
            low[present], median[present], high[present] = np.nanquantile(values[:, present], (0.1, 0.5, 0.9), axis=0)
            axes.fill_between(grid, low, high, color=colour, alpha=0.22, lw=0)
            axes.plot(grid, median, color=colour, lw=1.3)
            axes.set_ylim(bottom=0.0)
        upper.set_ylabel("clearance (m)")
        lower.set(ylabel="speed (m/s)", xlabel="distance driven (m)", xlim=(0.0, longest))
        return _svg(figure)


def drift(runs: Sequence[PlottedRun], variance: float, track: float) -> str | None:
    """Return the position error of runs over the distance driven, with the band that random wheel errors explain.

    It is None if nothing was reported.

    Args:
        runs: The runs.
        variance: Variance of each wheel's distance per metre, in m.
        track: Distance between the wheels, in m.
    """
    plotted = [run for run in runs if run.reported is not None]
    if not plotted:
        return None
    with _style():
        figure, axes = _plot(2.3)
        for run in plotted:
            assert run.reported is not None  # noqa: S101 - selected above
            error = np.hypot(*(run.reported[:, 1:3] - run.true[:, 1:3]).T)
            axes.plot(run.distance[::EVERY], error[::EVERY], color=REPORTED, lw=0.8, alpha=_opacity(plotted))
        grid = np.linspace(0.0, max(0.1, *(float(run.distance[-1]) for run in plotted)), GRID)
        if variance > 0.0:
            _, lateral = drift_band(grid, variance, track)
            axes.fill_between(
                grid, 0.0, 1.96 * lateral, color="#56B4E9", alpha=0.25, lw=0, label="95 % of wheel noise alone"
            )
            axes.legend(loc="upper left", frameon=False)
        axes.set(xlabel="distance driven (m)", ylabel="position error (m)", xlim=(0.0, grid[-1]))
        # The axis spans at least 0.1 m, so that an error of a centimetre looks small.
        axes.set_ylim(0.0, max(0.1, axes.get_ylim()[1]))
        return _svg(figure)


def intervals(rows: Sequence[tuple[str, float, float, float]]) -> str:
    """Return the success rates of rows with their intervals. A row is its title, rate, low and high, in [0, 1]."""
    with _style():
        figure, axes = _plot(0.55 + 0.3 * len(rows))
        for line, (_, rate, low, high) in enumerate(rows):
            axes.plot([100 * low, 100 * high], [line, line], color=TRUE, lw=2.2, solid_capstyle="butt")
            axes.plot([100 * rate], [line], "o", color=TRUE, ms=6)
        axes.set_yticks(range(len(rows)), [title for title, *_ in rows])
        axes.set(xlim=(-1, 101), xlabel="runs that reached the place and touched nothing (%)")
        axes.grid(axis="x", color="#ddd", lw=0.6)
        axes.set_ylim(len(rows) - 0.5, -0.5)
        return _svg(figure)


def timeline(series: Sequence[tuple[str, Floats, Floats]], unit: str) -> str:
    """Return values over time. A series is its name, its times in s and its values, which all are in `unit`."""
    with _style():
        figure, axes = _plot(1.9)
        for (name, times, values), colour in zip(series, (TRUE, REPORTED, "#009E73", "#CC79A7") * 4, strict=False):
            axes.plot(times, values, color=colour, lw=1.2, label=name)
        axes.set(xlabel="simulated time (s)", ylabel=unit)
        axes.legend(frameon=False, ncols=4, loc="upper left", bbox_to_anchor=(0.0, 1.25))
        return _svg(figure)


def _style() -> AbstractContextManager[None]:
    """Let figures have the style of the report. Matplotlib takes half a second to load, and many runs draw nothing."""
    import matplotlib as mpl  # noqa: PLC0415

    return mpl.rc_context(STYLE)


def _plot(height: float, rows: int = 1) -> tuple[Figure, Any]:
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots(rows, 1, sharex=True)


def _draw_floor(axes: Any, floor: Map) -> None:
    from matplotlib.patches import Polygon  # noqa: PLC0415

    for wall in floor.wall:
        for piece in wall_pieces(wall):
            axes.add_patch(Polygon(piece, fc=WALL, ec="none"))
    for obstacle in floor.obstacle:
        shape = [(corner.x, corner.y) for corner in obstacle.corner]
        axes.add_patch(Polygon(shape, fc="#d9d4c7", ec=WALL, lw=0.8))
        middle = np.mean(shape, axis=0)
        axes.text(*middle, obstacle.name.upper(), ha="center", va="center", color="#666", fontsize=8)


def _opacity(runs: Sequence[PlottedRun]) -> float:
    return max(0.25, min(0.9, 6.0 / max(1, len(runs))))


def _resampled(grid: Floats, distance: Floats, values: Floats) -> Floats:
    """Return values at the distances of a grid; NaN beyond the end of the run."""
    return np.where(grid <= distance[-1], np.interp(grid, distance, values), np.nan)


def _svg(figure: Figure) -> str:
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    svg = text.getvalue()
    # Without the XML prolog, so that it can stand in a page, and as wide as the page.
    svg = svg[svg.index("<svg") :]
    return re.sub(r'width="[^"]*" height="[^"]*"|height="[^"]*"|width="[^"]*pt"', 'width="100%"', svg, count=1)
