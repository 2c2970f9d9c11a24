"""The report's drawings, as SVG to stand in a page. Pure but for matplotlib; nothing is asked of a network.

Colours are Okabe and Ito's, which people with other colour vision tell apart; what is true is solid, what a chair
believes is dashed, and no meaning is by colour alone.
"""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from intellwheels_experiments.batch.metrics import Floats, drift_band
from intellwheels_maps.check import wall_pieces
from intellwheels_schemas.messages import Map

TRUE, REPORTED, HIT, FLOOR, THING = "#0072B2", "#D55E00", "#CC0033", "#f4f4f1", "#9a9a94"
WIDTH: Final = 9.6
"""Inches: a page of 960 px."""
STYLE: Final[Any] = {"svg.fonttype": "none", "svg.hashsalt": "iw", "font.family": "sans-serif", "font.size": 9.0,
                "axes.spines.top": False, "axes.spines.right": False}  # fmt: skip
GRID: Final = 400
EACH: Final = 4
"""Every fourth tick of a path is drawn: five points a second at 20 Hz, and a page of forty runs stays small."""


@dataclass(frozen=True)
class Drawn:
    """A run as it is drawn.

    Attributes:
        seed: Its seed.
        success: Whether it succeeded.
        true: float64[n, 4], t, x, y, heading.
        reported: The same as the chair believed, or None.
        clearance: float64[n], m.
        speed: float64[n], m/s.
        contacts: x and y of each.
    """

    seed: str
    success: bool
    true: Floats
    reported: Floats | None
    clearance: Floats
    speed: Floats
    contacts: Sequence[tuple[float, float]]

    @property
    def way(self) -> Floats:
        """Metres driven at each tick."""
        return np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(self.true[:, 1]), np.diff(self.true[:, 2])))])


def paths(floor: Map, runs: Sequence[Drawn], goal: tuple[float, float, float] | None, colour: str = TRUE) -> str:
    """Return the paths of a row's runs over the floor.

    Args:
        floor: The floor.
        runs: The runs.
        goal: A place, x and y, and the distance that counts as there, in metres; None for no goal.
        colour: The colour of the body, see `agent_colours`.
    """
    corners = np.array([(c.x, c.y) for wall in floor.wall for c in wall.corner])
    (left, low), (right, high) = corners.min(axis=0) - 0.15, corners.max(axis=0) + 0.15
    height = min(6.0, (WIDTH - 0.7) * (high - low) / (right - left)) + 0.55
    with mpl.rc_context(STYLE):
        figure, axes = _plot(height)
        _draw_floor(axes, floor)
        if goal is not None:
            axes.add_patch(mpl.patches.Circle(goal[:2], goal[2], fill=False, ec="#009E73", lw=1.2))
        for run in runs:
            axes.plot(*run.true[::EACH, 1:3].T, color=colour, lw=0.8, alpha=_faint(runs))
            if run.reported is not None:
                axes.plot(*run.reported[::EACH, 1:3].T, color=REPORTED, lw=0.7, ls=(0, (4, 2)), alpha=_faint(runs))
        hits = [at for run in runs for at in run.contacts]
        if hits:
            axes.plot(*zip(*hits, strict=True), "x", color=HIT, ms=6, mew=1.6)
        axes.set(xlim=(left, right), ylim=(low, high), aspect="equal", xlabel="x (m)", ylabel="y (m)")
        return _svg(figure)


def along(runs: Sequence[Drawn]) -> str:
    """Return clearance and speed along the way: the median of a row's runs and the middle 80 % of them."""
    longest = max(0.1, *(float(run.way[-1]) for run in runs))
    grid = np.linspace(0.0, longest, GRID)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.6), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True)
        for axes, name, colour in ((upper, "clearance", "#009E73"), (lower, "speed", TRUE)):
            values = np.array([_on(grid, run.way, getattr(run, name)) for run in runs])
            there = ~np.isnan(values).all(axis=0)
            low, median, high = np.full((3, GRID), np.nan)
            low[there], median[there], high[there] = np.nanquantile(values[:, there], (0.1, 0.5, 0.9), axis=0)
            axes.fill_between(grid, low, high, color=colour, alpha=0.22, lw=0)
            axes.plot(grid, median, color=colour, lw=1.3)
            axes.set_ylim(bottom=0.0)
        upper.set_ylabel("clearance (m)")
        lower.set(ylabel="speed (m/s)", xlabel="way driven (m)", xlim=(0.0, longest))
        return _svg(figure)


def drift(runs: Sequence[Drawn], variance: float, track: float) -> str | None:
    """Return how far reported and true place part along the way, and how far errors of the wheels alone explain it.

    None where nothing is reported.
    """
    shown = [run for run in runs if run.reported is not None]
    if not shown:
        return None
    with mpl.rc_context(STYLE):
        figure, axes = _plot(2.3)
        for run in shown:
            assert run.reported is not None  # noqa: S101 - chosen so
            off = np.hypot(*(run.reported[:, 1:3] - run.true[:, 1:3]).T)
            axes.plot(run.way[::EACH], off[::EACH], color=REPORTED, lw=0.8, alpha=_faint(shown))
        grid = np.linspace(0.0, max(0.1, *(float(run.way[-1]) for run in shown)), GRID)
        if variance > 0.0:
            _, aside = drift_band(grid, variance, track)
            axes.fill_between(
                grid, 0.0, 1.96 * aside, color="#56B4E9", alpha=0.25, lw=0, label="95 % of wheel noise alone"
            )
            axes.legend(loc="upper left", frameon=False)
        axes.set(xlabel="way driven (m)", ylabel="error of place (m)", xlim=(0.0, grid[-1]))
        # Errors of less than a few centimetres are as good as none, and are drawn so.
        axes.set_ylim(0.0, max(0.1, axes.get_ylim()[1]))
        return _svg(figure)


def intervals(rows: Sequence[tuple[str, float, float, float]]) -> str:
    """Return the success of rows, each with its interval: title, share, low, high."""
    with mpl.rc_context(STYLE):
        figure, axes = _plot(0.55 + 0.3 * len(rows))
        for place, (_, share, low, high) in enumerate(rows):
            axes.plot([100 * low, 100 * high], [place, place], color=TRUE, lw=2.2, solid_capstyle="butt")
            axes.plot([100 * share], [place], "o", color=TRUE, ms=6)
        axes.set_yticks(range(len(rows)), [title for title, *_ in rows])
        axes.set(xlim=(-1, 101), xlabel="runs that reached the place and touched nothing (%)")
        axes.grid(axis="x", color="#ddd", lw=0.6)
        axes.set_ylim(len(rows) - 0.5, -0.5)
        return _svg(figure)


def timeline(series: Sequence[tuple[str, Floats, Floats]], unit: str) -> str:
    """Return values over time: name, times in s, values."""
    with mpl.rc_context(STYLE):
        figure, axes = _plot(1.9)
        for (name, times, values), colour in zip(series, (TRUE, REPORTED, "#009E73", "#CC79A7") * 4, strict=False):
            axes.plot(times, values, color=colour, lw=1.2, label=name)
        axes.set(xlabel="simulated time (s)", ylabel=unit)
        axes.legend(frameon=False, ncols=4, loc="upper left", bbox_to_anchor=(0.0, 1.25))
        return _svg(figure)


def _plot(height: float) -> tuple[Figure, Any]:
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots()


def _draw_floor(axes: Any, floor: Map) -> None:
    for wall in floor.wall:
        for piece in wall_pieces(wall):
            axes.add_patch(mpl.patches.Polygon(piece, fc=THING, ec="none"))
    for obstacle in floor.obstacle:
        shape = [(corner.x, corner.y) for corner in obstacle.corner]
        axes.add_patch(mpl.patches.Polygon(shape, fc="#d9d4c7", ec=THING, lw=0.8))
        middle = np.mean(shape, axis=0)
        axes.text(*middle, obstacle.name.upper(), ha="center", va="center", color="#666", fontsize=8)


def _faint(runs: Sequence[Drawn]) -> float:
    return max(0.25, min(0.9, 6.0 / max(1, len(runs))))


def _on(grid: Floats, way: Floats, values: Floats) -> Floats:
    """Return values on a grid of ways driven; NaN beyond the end."""
    found = np.interp(grid, way, values)
    return np.where(grid <= way[-1], found, np.nan)


def _svg(figure: Figure) -> str:
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    drawn = text.getvalue()
    # Without the prolog, so that it may stand in a page, and as wide as the page.
    drawn = drawn[drawn.index("<svg") :]
    return re.sub(r'width="[^"]*" height="[^"]*"|height="[^"]*"|width="[^"]*pt"', 'width="100%"', drawn, count=1)
