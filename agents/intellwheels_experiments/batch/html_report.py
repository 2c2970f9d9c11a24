"""A batch as one page of HTML that needs nothing else: tables, drawings, and where all of it comes from."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Final

import msgspec

from intellwheels_experiments.batch import report_drawings
from intellwheels_experiments.batch.findings import sentences
from intellwheels_experiments.batch.report_drawings import Drawn
from intellwheels_experiments.batch.run_store import StoredRun
from intellwheels_experiments.batch.summary import Comparison, Line, Summary
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
"""Metres of odometry error below which there is none."""
MANY: Final = 12
"""Rows from which on what is told of each is folded."""

_MEASURES: Final = (
    ("reached", "runs that were within the place at the end"),
    ("time", "simulated time to the end of the run, when all who have a place are there or time is up, s"),
    ("way", "length of the true path, m"),
    ("clearance", "least distance from anything in the run, m; the least of all runs in brackets"),
    ("SPL", "success weighted by path length, in [0, 1]; the mean of a batch is its SPL (Anderson et al. 2018)"),
    ("SPARC", "spectral arc length of the speed; nearer to 0 is smoother (Balasubramanian et al. 2015)"),
    ("LDLJ", "log dimensionless jerk of the speed; nearer to 0 is smoother (the same)"),
    ("effort", "way of the user's stick in full deflections (after Urdiales et al. 2011); only where a person drives"),
    ("odometry error", "between the place that the wheels tell and the true one at the end, m"),
)


_DIFFERENCES: Final = (
    ("clearance", "clearance", "m", 3), ("time", "time", "s", 2), ("way", "path", "m", 2),
    ("odometry error", "odometry_error", "m", 3),
)  # fmt: skip
"""What a column is called, the measure, its unit and the digits."""


@dataclass(frozen=True)
class HtmlReport:
    """What the page is about.

    Attributes:
        scene: The scene.
        floor: Its floor.
        summary: The batch summed up.
        runs: Its runs.
        drawn: The runs of each row as they are drawn.
        drift: For each row the variance of its wheels, m, and its track, m.
        origin: Where it comes from: names and values.
        timelines: Further drawings of a row, by its name: what it shows and the SVG.
    """

    scene: Scene
    floor: Map
    summary: Summary
    runs: Sequence[StoredRun]
    drawn: Mapping[str, Sequence[Drawn]]
    drift: Mapping[str, tuple[float, float]]
    origin: Mapping[str, str]
    timelines: Mapping[str, Sequence[tuple[str, str]]]


def floor_hash(floor: Map) -> str:
    """Return the floor's hash as the simulator tells it: 16 hex digits of BLAKE2b-64 over its JSON."""
    return hashlib.blake2b(msgspec.json.encode(floor), digest_size=8).hexdigest()


def render(page: HtmlReport) -> str:
    """Return the page."""
    title = page.scene.title or page.scene.name
    seeds = len({run.seed for run in page.runs})
    lead = f"{len(page.summary.lines)} rows, {seeds} seeds each, on the floor {page.floor.title or page.floor.name}."
    parts = [
        f"<h1>{escape(title)}</h1><p class=lead>{escape(lead)} Rows share their seeds. Everything is scored by where "
        "the chair truly was, never by what it believed.</p>",
        _sweep(page),
        _findings(page),
        _results(page),
        _comparisons(page),
        _umbmark(page),
        _measures(page),
        _died(page),
        *(_folded(page, _row(page, line), line) for line in page.summary.lines if page.drawn.get(line.name)),
        _origin(page),
    ]
    body = "\n".join(part for part in parts if part)
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width,initial-scale=1"><style>{_STYLE}</style></head>'
        f"<body>\n{body}\n</body></html>\n"
    )


def _sweep(page: HtmlReport) -> str:
    """Return the rows of several factors as a grid of how many succeeded."""
    found = sweep(page.scene.experiment, page.summary.lines)
    if found is None:
        return ""
    head = "".join(f"<th class=t>{escape(title)}</th>" for title in found.down)
    head += "".join(f"<th>{'<br>'.join(escape(one) for one in column)}</th>" for column in found.columns)
    body = "".join(
        "<tr>" + "".join(f"<td class=t>{escape(level)}</td>" for level in levels)
        + "".join(_cell(line) for line in cells) + "</tr>"
        for levels, cells in found.rows
    )  # fmt: skip
    across = escape(" and ".join(title.lower() for title in found.across))
    return (
        f"<h2>At a glance</h2><p>Runs that succeeded, of how many; across: {across}. Green: all, yellow: some, "
        "red: none.</p>"
        f"<div class=wide><table class=grid><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _cell(line: Line | None) -> str:
    if line is None or not line.runs:
        return "<td></td>"
    kind = "all" if line.succeeded == line.runs else "some" if line.succeeded else "none"
    return f"<td class={kind}>{line.succeeded} / {line.runs}</td>"


def _folded(page: HtmlReport, text: str, line: Line | None = None) -> str:
    """Return what is long of a batch with many rows behind a line that opens it."""
    if len(page.summary.lines) <= MANY:
        return text
    title = "Row by row" if line is None else f"{escape(line.title)}: {line.succeeded} / {line.runs}"
    return f"<details><summary>{title}</summary>{text}</details>"


def _row_title(page: HtmlReport) -> str:
    """Return what tells the rows apart."""
    factors = page.scene.experiment.factor if page.scene.experiment else ()
    return escape(", ".join(factor.title or factor.name for factor in factors)) or "row"


def _results(page: HtmlReport) -> str:
    heads = (
        _row_title(page),
        "runs",
        "succeeded",
        "95 % interval",
        "runs with a collision",
        "contacts physical",
        "virtual",
    )
    rows = [
        (
            escape(line.title), str(line.runs),
            f"<b>{_percent(line.succeeded, line.runs)}</b> <small>{line.succeeded}</small>",
            f"{100 * line.interval.low:.0f} to {100 * line.interval.high:.0f} %", str(line.collided),
            str(line.physical), str(line.virtual),
        )
        for line in page.summary.lines
    ]  # fmt: skip
    points = [(one.title, one.succeeded / one.runs if one.runs else 0.0, *one.interval) for one in page.summary.lines]
    return (
        "<h2>Results</h2><p>A run succeeds when the chair reaches its place and touches nothing where it "
        "truly is. A contact counts where it begins; physical ones are of a chair of hardware with what is "
        "really there, "
        "virtual ones are within a simulation, where a chair of hardware is shown as it is reported. "
        "Intervals are Wilson's.</p>"
        + _folded(page, _table(heads, rows) + f"<figure>{report_drawings.intervals(points)}</figure>")
    )


def _findings(page: HtmlReport) -> str:
    told = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences(page.summary))
    return f"<h2>What these runs say</h2><ul>{told}</ul>" if told else ""


def _comparisons(page: HtmlReport) -> str:
    if not page.summary.comparisons:
        return ""
    titles = {line.name: line.title for line in page.summary.lines}
    margin = page.scene.experiment.margin if page.scene.experiment else 0.0
    heads = (
        "first, against second", "expected of the first", "difference", "95 % interval", "only first / only second",
        "p", "equivalent", "found",
    )  # fmt: skip
    rows = [_comparison(one, titles) for one in page.summary.comparisons]
    return (
        "<h2>Comparisons</h2><p>Two rows are compared seed by seed. The difference is that of their success, first "
        "less second, in percentage points, with Tango's score interval; p is of McNemar's exact test, two-sided, over "
        f"the seeds that only one of the two succeeded with. Rows are equivalent when the difference is within "
        f"{100 * margin:.0f} points at 5 % each way. What these runs cannot tell is said to be undecided.</p>"
        + _table(heads, rows, words=2)
        + _differences(page.summary.comparisons, titles)
    )


def _differences(comparisons: Sequence[Comparison], titles: Mapping[str, str]) -> str:
    heads = ("first, against second", *(f"{name}, {unit}" for name, _, unit, _ in _DIFFERENCES))
    rows = []
    for one in comparisons:
        if one.second is None or not one.differences:
            continue
        cells = [f"{escape(titles[one.first])}, against {escape(titles[one.second])}"]
        for _, key, _, digits in _DIFFERENCES:
            mean, (low, high) = one.differences.get(key, (math.nan, (0.0, 0.0)))
            told = f"{mean:+.{digits}f}<br><small>{low:+.{digits}f} to {high:+.{digits}f}</small>"
            cells.append("" if math.isnan(mean) else told)
        rows.append(cells)
    if not rows:
        return ""
    return (
        "<p>How far the measures differ, first less second: the mean over the seeds that both reached their place "
        "with, and its 95 % interval by Student's t of the paired differences.</p>" + _table(heads, rows)
    )


def _comparison(one: Comparison, titles: Mapping[str, str]) -> tuple[str, ...]:
    name = escape(titles[one.first]) + (f", against {escape(titles[one.second])}" if one.second else "")
    style = {"as expected": "yes", "otherwise": "no", "undecided": "open"}.get(one.verdict, "")
    expected = {"worse": "it is worse", "better": "it is better", "equivalent": "they are equivalent",
                "collision-free": "it touches nothing"}.get(one.expect or "", "")  # fmt: skip
    found = f'<span class="{style}">{one.verdict}</span>' if style else ""
    paired = one.paired
    if paired is None:
        return name, expected, "", "", "", "", "", found
    low, high = (100 * value for value in paired.interval)
    return (
        name, expected, f"{100 * paired.difference:+.0f}", f"{low:+.0f} to {high:+.0f}",
        f"{paired.first_only} / {paired.second_only}", _p(paired.p), "yes" if paired.equivalent else "no", found,
    )  # fmt: skip


def _umbmark(page: HtmlReport) -> str:
    found = page.summary.umbmark
    if found is None:
        return ""
    told = (
        ("E<sub>d</sub>, the right wheel's diameter over the left one's", found.wheels),
        ("E<sub>b</sub>, the true track over the nominal one", found.base),
    )
    rows = [
        (
            name, f"{one.true:.4f}", f"<b>{one.found:.4f}</b>", "" if one.error is None else f"{one.error:.5f}",
            f"{one.found - one.true:+.4f}",
        )
        for name, one in told
    ]  # fmt: skip
    return (
        f"<h2>UMBmark</h2><p>The chair drives squares of {found.side:g} m by its odometry, which knows its data sheet "
        f"alone ({found.track:g} m between the wheels). How far it truly ends from where the odometry says, to the "
        f"left and to the right, tells how its wheels really are (Borenstein and Feng 1996; {found.seeds} squares each "
        "way). A chair as its data sheet says has 1. The method supposes small errors and turns on the spot: "
        "it is right to about 0.0005 here, whatever the standard error.</p>"
        + _table(("figure", "true", "found", "standard error", "found less true"), rows)
    )


def _measures(page: HtmlReport) -> str:
    heads = (_row_title(page), *(name for name, _ in _MEASURES))
    rows = []
    for line in page.summary.lines:
        clearance = _spread(line, "clearance", 2)
        if clearance and (spread := line.spread.get("clearance")):
            clearance += f" <small>({max(0.0, spread.least):.2f})</small>"
        rows.append(
            (
                escape(line.title), f"{line.reached} / {line.runs}", _spread(line, "time", 1), _spread(line, "path", 2),
                clearance, _spread(line, "spl", 2), _spread(line, "sparc", 2), _spread(line, "ldlj", 1),
                _spread(line, "effort", 1), _spread(line, "odometry_error", 3),
            )
        )  # fmt: skip
    # A measure that no row has tells nothing.
    columns = [at for at in range(len(heads)) if any(row[at] for row in rows)]
    told = "; ".join(f"<b>{name}</b>: {what}" for at, (name, what) in enumerate(_MEASURES, start=1) if at in columns)
    shown = _table([heads[at] for at in columns], [[row[at] for at in columns] for row in rows])
    return f"<h2>Measures</h2><p>Medians, with the quartiles below. {told}.</p>" + _folded(page, shown)


def _died(page: HtmlReport) -> str:
    died = [run for run in page.runs if run.measured is None]
    if not died:
        return ""
    told = "\n".join(f"{run.row}, seed {run.seed}: {run.died}" for run in died)
    return f"<h2>Runs that came to no end</h2><p>They count nowhere above.</p><pre>{escape(told)}</pre>"


def _row(page: HtmlReport, line: Line) -> str:
    runs = page.drawn[line.name]
    subject = page.scene.experiment.subject if page.scene.experiment else page.scene.cast[0].name
    goals = page.scene.end.reach if page.scene.end else ()
    reach = next((one for one in goals if one.agent == subject), None)
    places = page.floor.grid.position if page.floor.grid else ()
    place = next((one for one in places if reach and one.name == reach.place), None)
    goal = (place.x, place.y, reach.within) if place and reach else None
    colour = css(colour_of(subject))
    drift = report_drawings.drift(runs, *page.drift.get(line.name, (0.0, 1.0)))
    key = (
        f'<span><i style="border-color:{colour}"></i>where it truly was</span>'
        f'<span><i style="border-color:{report_drawings.REPORTED};border-top-style:dashed"></i>'
        "where it was reported</span>"
        f'<span style="color:{report_drawings.HIT}"><b>&times;</b> contact</span>'
    )
    parts = [
        f"<h2>{escape(line.title)}</h2><p>{_percent(line.succeeded, line.runs)} of {line.runs} runs succeeded, "
        f"{line.collided} with a collision.</p>",
        f"<figure><p class=key>{key}</p>{report_drawings.paths(page.floor, runs, goal, colour)}</figure>",
        f"<h3>Clearance and speed along the way</h3><p>Median and middle 80 % of the runs.</p>"
        f"<figure>{report_drawings.along(runs)}</figure>",
    ]
    errors = line.spread.get("odometry_error")
    # Of a chair whose odometry is exact there is nothing to be seen.
    if drift and errors is not None and errors.most >= EXACT:
        parts.append(
            "<h3>Drift of what is reported</h3><p>How far the reported place is from the true one. The band is what "
            "independent errors of the two wheels alone explain on a straight way, sd = &radic;(2kL<sup>3</sup>/3)/b; "
            f"what lies above it is systematic.</p><figure>{drift}</figure>"
        )
    parts += [f"<h3>{escape(what)}</h3><figure>{drawn}</figure>" for what, drawn in page.timelines.get(line.name, ())]
    return "\n".join(parts)


def _origin(page: HtmlReport) -> str:
    told = "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in page.origin.items())
    return f"<h2>Where this comes from</h2><dl>{told}</dl>"


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]], words: int = 1) -> str:
    head = "".join(f"<th>{name}</th>" for name in heads)
    lines = [
        "".join(f"<td{' class=t' if at < words else ''}>{cell}</td>" for at, cell in enumerate(row)) for row in rows
    ]
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f"<div class=wide><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>"


def _spread(line: Line, name: str, digits: int) -> str:
    found = line.spread.get(name)
    if found is None:
        return ""
    return f"{found.median:.{digits}f}<br><small>{found.low:.{digits}f} to {found.high:.{digits}f}</small>"


def _percent(part: int, whole: int) -> str:
    return f"{100 * part / whole:.0f} %" if whole else "no run"


def _p(value: float) -> str:
    return "&lt; 0.001" if value < 0.001 else f"{value:.3f}"
