"""The report of a batch: one self-contained HTML page with findings, tables, drawings and the origin of the data."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Final

import msgspec

from intellwheels_experiments.batch import report_drawings
from intellwheels_experiments.batch.findings import counted, sentences
from intellwheels_experiments.batch.report_drawings import PlottedRun
from intellwheels_experiments.batch.run_store import StoredRun
from intellwheels_experiments.batch.summary import Comparison, RowSummary, Summary
from intellwheels_experiments.batch.sweep import sweep
from intellwheels_schemas.agent_colours import colour_of, css
from intellwheels_schemas.messages import Map, Scene

_STYLE: Final = """
:root { color-scheme: light }
body { font: 15px/1.5 system-ui, sans-serif; color: #1c1c1a; max-width: 1010px; margin: 2rem auto; padding: 0 1rem }
h1 { font-size: 1.6rem; margin: 0 } h2 { font-size: 1.2rem; margin: 2.2rem 0 .4rem }
h3 { font-size: 1rem; margin: 1.6rem 0 .2rem }
table { border-collapse: collapse; margin: .6rem 0; font-size: .88rem }
th, td { padding: .28rem .6rem; text-align: right; border-bottom: 1px solid #ddd; vertical-align: top }
th { border-bottom: 2px solid #888; font-weight: 600 }
th:first-child, td.t { text-align: left } td small { color: #666 }
p { max-width: 52rem; margin: .4rem 0 } .lead { color: #555; margin: .2rem 0 1rem }
.yes { color: #00664a; font-weight: 600 } .no { color: #b00030; font-weight: 600 }
.open { color: #8a5a00; font-weight: 600 }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1rem; font-size: .86rem }
dt { color: #555 } dd { margin: 0; font-family: ui-monospace, monospace; overflow-wrap: anywhere }
.wide { overflow-x: auto } figure { margin: .4rem 0 }
.key span { display: inline-block; margin-right: 1.4em }
.key i { display: inline-block; width: 1.8em; border-top: 3px solid; margin-right: .4em; vertical-align: middle }
table.grid td, table.grid th { text-align: center; white-space: nowrap }
table.grid td.t, table.grid th.t { text-align: left }
td.all { background: #d6ede4 } td.some { background: #fbeecb } td.none { background: #f8d8de }
details { margin: .8rem 0 } summary { cursor: pointer; font-weight: 600 }
pre { background: #f4f4f1; padding: .6rem; overflow-x: auto; font-size: .8rem }
"""

EXACT: Final = 1e-3
"""Metres of odometry error below which the odometry counts as exact."""
MANY: Final = 12
"""If a batch has more rows than this, the details of its rows are folded."""

_MEASURES: Final = (
    ("reached", "runs in which the chair was at its place at the end"),
    ("time", "simulated time until all agents were at their places or the time was up, s"),
    ("path", "length of the true path, m"),
    ("clearance", "smallest distance from anything during the run, m; in brackets the smallest of all runs"),
    ("SPL", "success weighted by path length, in [0, 1]; the SPL of a batch is the mean (Anderson et al. 2018)"),
    ("SPARC", "spectral arc length of the speed; closer to 0 is smoother (Balasubramanian et al. 2015)"),
    (
        "LDLJ",
        "log dimensionless jerk of the speed; closer to 0 is smoother (same source). It counts the duration: with the "
        "same start and stop it falls by 2.1 if the time doubles. Compare it at equal times; SPARC hardly counts it",
    ),
    ("effort", "length of the joystick's path in full deflections, if a person drives (after Urdiales et al. 2011)"),
    ("odometry error", "distance between the reported and the true position at the end, m"),
)


_DIFFERENCES: Final = (
    ("clearance", "clearance", "m", 3), ("time", "time", "s", 2), ("path", "path", "m", 2),
    ("odometry error", "odometry_error", "m", 3),
)  # fmt: skip
"""The column's title, the measure, its unit and its decimals."""


@dataclass(frozen=True)
class HtmlReport:
    """The contents of the page.

    Attributes:
        scene: The scene.
        floor: Its map.
        summary: The summary of the batch.
        runs: Its runs.
        plotted: The runs to draw, by row.
        drift: By row: the variance of each wheel's distance per metre, in m, and the track, in m.
        origin: Where the data comes from: names and values.
        timelines: Further drawings, by row: the title and the SVG of each.
    """

    scene: Scene
    floor: Map
    summary: Summary
    runs: Sequence[StoredRun]
    plotted: Mapping[str, Sequence[PlottedRun]]
    drift: Mapping[str, tuple[float, float]]
    origin: Mapping[str, str]
    timelines: Mapping[str, Sequence[tuple[str, str]]]


def floor_hash(floor: Map) -> str:
    """Return the hash of a map as the simulator reports it: 16 hex digits, BLAKE2b-64 of its JSON."""
    return hashlib.blake2b(msgspec.json.encode(floor), digest_size=8).hexdigest()


def render(page: HtmlReport) -> str:
    """Return the page as HTML text."""
    title = page.scene.title or page.scene.name
    seeds = len({run.seed for run in page.runs})
    rows = counted(len(page.summary.lines), "row")
    lead = f"{rows} with {counted(seeds, 'seed')} each on the map {page.floor.title or page.floor.name}."
    parts = [
        f"<h1>{escape(title)}</h1><p class=lead>{escape(lead)} All rows use the same seeds. Runs are scored by the "
        "chair's true pose, not by the pose that the chair reports.</p>",
        _sweep(page),
        _findings(page),
        _results(page),
        _comparisons(page),
        _umbmark(page),
        _measures(page),
        _died(page),
        *(_folded(page, _row(page, row), row) for row in page.summary.lines if page.plotted.get(row.name)),
        _origin(page),
    ]
    body = "\n".join(part for part in parts if part)
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width,initial-scale=1"><style>{_STYLE}</style></head>'
        f"<body>\n{body}\n</body></html>\n"
    )


def _sweep(page: HtmlReport) -> str:
    """Return the grid of an experiment with several factors: how many runs of each row succeeded."""
    grid = sweep(page.scene.experiment, page.summary.lines)
    if grid is None:
        return ""
    head = "".join(f"<th class=t>{escape(title)}</th>" for title in grid.down)
    head += "".join(f"<th>{'<br>'.join(escape(level) for level in column)}</th>" for column in grid.columns)
    body = "".join(
        "<tr>" + "".join(f"<td class=t>{escape(level)}</td>" for level in levels)
        + "".join(_cell(row) for row in cells) + "</tr>"
        for levels, cells in grid.rows
    )  # fmt: skip
    across = escape(" and ".join(title.lower() for title in grid.across))
    return (
        f"<h2>At a glance</h2><p>Successful runs / all runs. Across: {across}. Green: all succeeded, yellow: some, "
        "red: none.</p>"
        f"<div class=wide><table class=grid><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _cell(row: RowSummary | None) -> str:
    if row is None or not row.runs:
        return "<td></td>"
    kind = "all" if row.succeeded == row.runs else "some" if row.succeeded else "none"
    return f"<td class={kind}>{row.succeeded} / {row.runs}</td>"


def _folded(page: HtmlReport, text: str, row: RowSummary | None = None) -> str:
    """Return a text folded behind a line that opens it, if the batch has many rows."""
    if len(page.summary.lines) <= MANY:
        return text
    title = "Row by row" if row is None else f"{escape(row.title)}: {row.succeeded} / {row.runs}"
    return f"<details><summary>{title}</summary>{text}</details>"


def _row_title(page: HtmlReport) -> str:
    """Return the title of the column that names the rows."""
    factors = page.scene.experiment.factor if page.scene.experiment else ()
    return escape(", ".join(factor.title or factor.name for factor in factors)) or "row"


def _results(page: HtmlReport) -> str:
    heads = (
        _row_title(page),
        "runs",
        "succeeded",
        "95 % interval",
        "runs with a collision",
        "physical contacts",
        "virtual contacts",
    )
    rows = [
        (
            escape(row.title), str(row.runs),
            f"<b>{_percent(row.succeeded, row.runs)}</b> <small>{row.succeeded}</small>",
            f"{100 * row.interval.low:.0f} to {100 * row.interval.high:.0f} %", str(row.collided),
            str(row.physical), str(row.virtual),
        )
        for row in page.summary.lines
    ]  # fmt: skip
    points = [(row.title, row.succeeded / row.runs if row.runs else 0.0, *row.interval) for row in page.summary.lines]
    return (
        "<h2>Results</h2><p>A run succeeds if the chair reaches its place and touches nothing at its true pose. A "
        "contact that lasts counts once. Physical contacts are those of a real chair with real things. Virtual "
        "contacts happen inside a simulation, where a real chair is at its reported pose. The intervals are Wilson's."
        "</p>" + _folded(page, _table(heads, rows) + f"<figure>{report_drawings.intervals(points)}</figure>")
    )


def _findings(page: HtmlReport) -> str:
    findings = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences(page.summary))
    return f"<h2>Findings</h2><ul>{findings}</ul>" if findings else ""


def _comparisons(page: HtmlReport) -> str:
    if not page.summary.comparisons:
        return ""
    titles = {row.name: row.title for row in page.summary.lines}
    margin = page.scene.experiment.margin if page.scene.experiment else 0.0
    heads = (
        "first and second row", "expectation", "difference", "95 % interval", "only first / only second succeeded",
        "p", "equivalent", "result",
    )  # fmt: skip
    rows = [_comparison(one, titles) for one in page.summary.comparisons]
    return (
        "<h2>Comparisons</h2><p>Two rows are compared seed by seed. The difference is the success rate of the first "
        "row minus that of the second, in percentage points, with Tango's score interval. The p value is that of "
        "McNemar's exact two-sided test over the seeds with which only one of the two rows succeeded. Two rows are "
        f"equivalent if the difference is within {100 * margin:.0f} points, tested at 5 % on each side. A result that "
        "these runs cannot settle is called undecided, and one of which runs are missing is called incomplete.</p>"
        + _table(heads, rows, text_columns=2)
        + _differences(page.summary.comparisons, titles)
    )


def _differences(comparisons: Sequence[Comparison], titles: Mapping[str, str]) -> str:
    heads = ("first and second row", *(f"{name}, {unit}" for name, _, unit, _ in _DIFFERENCES))
    rows = []
    for one in comparisons:
        if one.second is None or not one.differences:
            continue
        cells = [_pair(one, titles)]
        for _, key, _, digits in _DIFFERENCES:
            mean, (low, high) = one.differences.get(key, (math.nan, (0.0, 0.0)))
            cell = f"{mean:+.{digits}f}<br><small>{low:+.{digits}f} to {high:+.{digits}f}</small>"
            cells.append("" if math.isnan(mean) else cell)
        rows.append(cells)
    if not rows:
        return ""
    return (
        "<p>Differences of the measures, first row minus second: the mean over the seeds with which both rows reached "
        "their place, and its 95 % interval by Student's t of the paired differences.</p>" + _table(heads, rows)
    )


def _pair(comparison: Comparison, titles: Mapping[str, str]) -> str:
    first = escape(titles[comparison.first])
    return first + (f" and {escape(titles[comparison.second])}" if comparison.second else "")


def _comparison(comparison: Comparison, titles: Mapping[str, str]) -> tuple[str, ...]:
    pair = _pair(comparison, titles)
    styles = {"as expected": "yes", "otherwise": "no", "undecided": "open", "incomplete": "open"}
    style = styles.get(comparison.verdict, "")
    expectation = {"worse": "first is worse", "better": "first is better", "equivalent": "they are equivalent",
                   "collision-free": "it touches nothing"}.get(comparison.expect or "", "")  # fmt: skip
    result = {"otherwise": "not as expected"}.get(comparison.verdict, comparison.verdict)
    cell = f'<span class="{style}">{result}</span>' if style else ""
    paired = comparison.paired
    if paired is None:
        return pair, expectation, "", "", "", "", "", cell
    low, high = (100 * value for value in paired.interval)
    return (
        pair, expectation, f"{100 * paired.difference:+.0f}", f"{low:+.0f} to {high:+.0f}",
        f"{paired.first_only} / {paired.second_only}", _p(paired.p), "yes" if paired.equivalent else "no", cell,
    )  # fmt: skip


def _umbmark(page: HtmlReport) -> str:
    result = page.summary.umbmark
    if result is None:
        return ""
    factors = (
        ("E<sub>d</sub>, right wheel diameter / left wheel diameter", result.wheels),
        ("E<sub>b</sub>, true track / nominal track", result.base),
    )
    rows = [
        (
            name, f"{one.true:.4f}", f"<b>{one.found:.4f}</b>", "" if one.error is None else f"{one.error:.5f}",
            f"{one.found - one.true:+.4f}",
        )
        for name, one in factors
    ]  # fmt: skip
    return (
        f"<h2>UMBmark</h2><p>The chair drives squares of {result.side:g} m by odometry that uses the nominal wheel "
        f"data ({result.track:g} m between the wheels). The distance between its true end and its end by odometry, "
        "for squares to the left and to the right, reveals the true wheel data (Borenstein and Feng 1996; "
        f"{result.seeds} squares in each direction). Both factors are 1 for a chair that matches its data sheet. The "
        "method assumes small errors and turns on the spot. Here it is accurate to about 0.0005, however small the "
        "standard error.</p>" + _table(("factor", "true", "found", "standard error", "found minus true"), rows)
    )


def _measures(page: HtmlReport) -> str:
    heads = (_row_title(page), *(name for name, _ in _MEASURES))
    rows = []
    for row in page.summary.lines:
        clearance = _spread(row, "clearance", 2)
        if clearance and (spread := row.spread.get("clearance")):
            clearance += f" <small>({max(0.0, spread.least):.2f})</small>"
        rows.append(
            (
                escape(row.title), f"{row.reached} / {row.runs}", _spread(row, "time", 1), _spread(row, "path", 2),
                clearance, _spread(row, "spl", 2), _spread(row, "sparc", 2), _spread(row, "ldlj", 1),
                _spread(row, "effort", 1), _spread(row, "odometry_error", 3),
            )
        )  # fmt: skip
    # A measure that no row has gets no column.
    columns = [at for at in range(len(heads)) if any(cells[at] for cells in rows)]
    legend = "; ".join(f"<b>{name}</b>: {what}" for at, (name, what) in enumerate(_MEASURES, start=1) if at in columns)
    table = _table([heads[at] for at in columns], [[cells[at] for at in columns] for cells in rows])
    return f"<h2>Measures</h2><p>Medians, with the quartiles below. {legend}.</p>" + _folded(page, table)


def _died(page: HtmlReport) -> str:
    died = [run for run in page.runs if run.measured is None]
    if not died:
        return ""
    reasons = "\n".join(f"{run.row}, seed {run.seed}: {run.died or 'it was not run'}" for run in died)
    return (
        "<h2>Unfinished runs</h2><p>These runs did not reach their end. None of the numbers above includes them.</p>"
        f"<pre>{escape(reasons)}</pre>"
    )


def _row(page: HtmlReport, row: RowSummary) -> str:
    runs = page.plotted[row.name]
    subject = page.scene.experiment.subject if page.scene.experiment else page.scene.cast[0].name
    goals = page.scene.end.reach if page.scene.end else ()
    reach = next((one for one in goals if one.agent == subject), None)
    places = page.floor.grid.position if page.floor.grid else ()
    place = next((one for one in places if reach and one.name == reach.place), None)
    goal = (place.x, place.y, reach.within) if place and reach else None
    colour = css(colour_of(subject))
    drift = report_drawings.drift(runs, *page.drift.get(row.name, (0.0, 1.0)))
    key = (
        f'<span><i style="border-color:{colour}"></i>true path</span>'
        f'<span><i style="border-color:{report_drawings.REPORTED};border-top-style:dashed"></i>reported path</span>'
        f'<span style="color:{report_drawings.CONTACT}"><b>&times;</b> contact</span>'
    )
    parts = [
        f"<h2>{escape(row.title)}</h2><p>{_percent(row.succeeded, row.runs)} of {row.runs} runs succeeded. "
        f"Runs with a collision: {row.collided}.</p>",
        f"<figure><p class=key>{key}</p>{report_drawings.paths(page.floor, runs, goal, colour)}</figure>",
        f"<h3>Clearance and speed along the path</h3><p>The median and the middle 80 % of the runs.</p>"
        f"<figure>{report_drawings.along(runs)}</figure>",
    ]
    errors = row.spread.get("odometry_error")
    # A chair with exact odometry has no error to show.
    if drift and errors is not None and errors.most >= EXACT:
        parts.append(
            "<h3>Drift of the reported position</h3><p>The distance between the reported and the true position. The "
            "band shows what independent random errors of the two wheels explain on a straight path, "
            "sd = &radic;(2kL<sup>3</sup>/3)/b. Errors above the band are systematic.</p>"
            f"<figure>{drift}</figure>"
        )
    parts += [f"<h3>{escape(title)}</h3><figure>{svg}</figure>" for title, svg in page.timelines.get(row.name, ())]
    return "\n".join(parts)


def _origin(page: HtmlReport) -> str:
    items = "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in page.origin.items())
    return f"<h2>Origin of the data</h2><dl>{items}</dl>"


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]], text_columns: int = 1) -> str:
    head = "".join(f"<th>{name}</th>" for name in heads)
    lines = [
        "".join(f"<td{' class=t' if at < text_columns else ''}>{cell}</td>" for at, cell in enumerate(row))
        for row in rows
    ]
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f"<div class=wide><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>"


def _spread(row: RowSummary, name: str, digits: int) -> str:
    spread = row.spread.get(name)
    if spread is None:
        return ""
    return f"{spread.median:.{digits}f}<br><small>{spread.low:.{digits}f} to {spread.high:.{digits}f}</small>"


def _percent(part: int, whole: int) -> str:
    return f"{100 * part / whole:.0f} %" if whole else "none"


def _p(value: float) -> str:
    return "&lt; 0.001" if value < 0.001 else f"{value:.3f}"
