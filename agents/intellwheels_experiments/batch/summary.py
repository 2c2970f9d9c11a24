"""The summary of a batch: its rows and its comparisons. Pure: runs in, numbers, JSON and JUnit out."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final, Literal, TypeAlias
from xml.etree import ElementTree as Tree

import msgspec
import numpy as np

from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.run_measures import RunMeasures
from intellwheels_experiments.batch.run_store import StoredRun
from intellwheels_experiments.batch.statistics import Interval, Paired, compare, mean_difference, wilson
from intellwheels_experiments.batch.umbmark import UmbmarkResult
from intellwheels_schemas.messages import Compare, Experiment

_NOT_XML: Final = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 cannot represent."""
DECIDES: Final = 0.05
"""The p value below which two rows differ."""
SPREAD: Final = ("clearance", "time", "path", "spl", "ldlj", "sparc", "effort", "agreement", "odometry_error")
"""Measures that are summarized by their median and quartiles."""
DIFFERENCES: Final = ("clearance", "time", "path", "odometry_error")
"""Measures that are compared between two rows, besides success."""

Verdict: TypeAlias = Literal["as expected", "otherwise", "undecided", "not asked", "incomplete"]


class Spread(msgspec.Struct, frozen=True, kw_only=True):
    """The distribution of a measure.

    Attributes:
        runs: Number of runs that have the measure.
        median: The median.
        low: The lower quartile.
        high: The upper quartile.
        least: The smallest value.
        most: The largest value.
    """

    runs: int
    median: float
    low: float
    high: float
    least: float
    most: float


class RowSummary(msgspec.Struct, frozen=True, kw_only=True):
    """The summary of a row.

    Attributes:
        name: The row's name.
        title: The row's title.
        runs: Number of runs that reached their end.
        died: The seeds of the runs that began and did not.
        succeeded: Number of runs that reached their place and touched nothing.
        interval: Wilson's 95 % interval of the success rate.
        reached: Number of runs that reached their place.
        collided: Number of runs that touched something.
        physical: Number of contacts with real things, in all runs.
        virtual: Number of contacts with simulated things, in all runs.
        spread: The distributions of the other measures, by name.
        missing: The seeds of the runs that were not made.
    """

    name: str
    title: str
    runs: int
    died: tuple[str, ...]
    succeeded: int
    interval: Interval
    reached: int
    collided: int
    physical: int
    virtual: int
    spread: dict[str, Spread]
    missing: tuple[str, ...] = ()


class Comparison(msgspec.Struct, frozen=True, kw_only=True):
    """The comparison of two rows, or the check of one row alone.

    Attributes:
        first: The first row.
        second: The second row; None for the check of one row.
        expect: What the experiment expects of the first row; None if nothing.
        verdict: Whether the runs confirm the expectation; `incomplete` if some of them were not made.
        paired: The comparison of their success; None for one row, without a common seed, or if runs were not made.
        differences: The difference of further measures by name, first minus second: its mean over the seeds with which
            both rows reached their place, and its interval.
    """

    first: str
    second: str | None
    expect: str | None
    verdict: Verdict
    paired: Paired | None = None
    differences: dict[str, tuple[float, Interval]] = msgspec.field(default_factory=dict)


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """The summary of a batch, as `summary.json` holds it.

    Attributes:
        lines: The summaries of its rows.
        comparisons: The comparisons that the experiment asks for.
        umbmark: The UMBmark of its squares, if the experiment asks for it.
    """

    lines: tuple[RowSummary, ...]
    comparisons: tuple[Comparison, ...]
    umbmark: UmbmarkResult | None = None


def summarize(rows: Sequence[Row], runs: Sequence[StoredRun], experiment: Experiment | None) -> Summary:
    """Return the summary of a batch.

    Args:
        rows: Its rows.
        runs: The runs of all rows.
        experiment: The scene's experiment, which says what to compare.
    """
    of_row = {row.name: [run for run in runs if run.row == row.name] for row in rows}
    summaries = {row.name: _summarize_row(row, of_row[row.name]) for row in rows}
    # A batch may have some of the rows only. A comparison is made if the batch has both of its rows.
    wanted = experiment.compare if experiment else ()
    possible = [compared for compared in wanted if {compared.first, compared.second or compared.first} <= of_row.keys()]
    margin = experiment.margin if experiment else 0.0
    return Summary(
        lines=tuple(summaries.values()),
        comparisons=tuple(_comparison(compared, summaries, of_row, margin) for compared in possible),
    )


def _summarize_row(row: Row, runs: Sequence[StoredRun]) -> RowSummary:
    ended = [run.measured for run in runs if run.measured is not None]
    succeeded = sum(one.success for one in ended)
    spread = {}
    for name in SPREAD:
        values = [value for one in ended if (value := getattr(one, name)) is not None]
        if values:
            low, median, high = np.quantile(values, (0.25, 0.5, 0.75)).tolist()
            spread[name] = Spread(
                runs=len(values), median=median, low=low, high=high, least=min(values), most=max(values)
            )
    return RowSummary(
        name=row.name,
        title=row.title,
        runs=len(ended),
        died=tuple(run.seed for run in runs if run.died),
        succeeded=succeeded,
        interval=wilson(succeeded, len(ended)),
        reached=sum(one.reached for one in ended),
        collided=sum(one.collided for one in ended),
        physical=sum(one.contacts_physical for one in ended),
        virtual=sum(one.contacts_virtual for one in ended),
        spread=spread,
        missing=tuple(run.seed for run in runs if run.is_missing),
    )


def _comparison(
    compared: Compare, summaries: dict[str, RowSummary], of_row: dict[str, list[StoredRun]], margin: float
) -> Comparison:
    both = (compared.first, compared.second or compared.first)
    if any(summaries[name].missing for name in both):
        return Comparison(first=compared.first, second=compared.second, expect=compared.expect, verdict="incomplete")
    if compared.second is None:
        row = summaries[compared.first]
        verdict: Verdict = "undecided" if row.runs == 0 else "as expected" if row.collided == 0 else "otherwise"
        return Comparison(first=compared.first, second=None, expect=compared.expect, verdict=verdict)
    second = {run.seed: run.measured for run in of_row[compared.second]}
    pairs = [
        (run.measured, other)
        for run in of_row[compared.first]
        if run.measured is not None and (other := second.get(run.seed)) is not None
    ]
    if not pairs:
        verdict = "not asked" if compared.expect is None else "undecided"
        return Comparison(first=compared.first, second=compared.second, expect=compared.expect, verdict=verdict)
    paired = compare([a.success for a, _ in pairs], [b.success for _, b in pairs], margin)
    reached = [(a, b) for a, b in pairs if a.reached and b.reached]
    return Comparison(
        first=compared.first,
        second=compared.second,
        expect=compared.expect,
        verdict=_verdict(compared.expect, paired, margin),
        paired=paired,
        differences={name: found for name in DIFFERENCES if (found := _difference(name, reached)) is not None},
    )


def _difference(name: str, pairs: Sequence[tuple[RunMeasures, RunMeasures]]) -> tuple[float, Interval] | None:
    """Return the mean difference of a measure and its interval; None if fewer than two pairs of runs have it."""
    values = [(getattr(a, name), getattr(b, name)) for a, b in pairs]
    complete = [pair for pair in values if None not in pair]
    return mean_difference(*zip(*complete, strict=True)) if len(complete) > 1 else None


def _verdict(expect: str | None, paired: Paired, margin: float) -> Verdict:
    if expect is None:
        return "not asked"
    differs = paired.p < DECIDES
    if expect == "equivalent":
        # An interval entirely outside the margin rules out equivalence. One that straddles the margin decides nothing.
        apart = paired.interval.low > margin or paired.interval.high < -margin
        return "as expected" if paired.equivalent else "otherwise" if apart else "undecided"
    right_direction = paired.difference < 0.0 if expect == "worse" else paired.difference > 0.0
    if differs:
        return "as expected" if right_direction else "otherwise"
    # A difference within the margin is too small to count as worse or better.
    return "otherwise" if paired.equivalent else "undecided"


def to_json(summary: Summary) -> bytes:
    """Return a summary as indented JSON with a final newline."""
    return msgspec.json.format(msgspec.json.encode(summary), indent=2) + b"\n"


def to_junit(name: str, summary: Summary, runs: Sequence[StoredRun]) -> str:
    """Return a batch as JUnit XML: a case per run and per expectation.

    A run that died has an error. What was not run, and an expectation that the runs do not decide, is skipped.
    """
    suites = Tree.Element("testsuites", name=name)
    for row in summary.lines:
        of_row = [run for run in runs if run.row == row.name]
        suite = Tree.SubElement(suites, "testsuite", name=row.name, tests=str(len(of_row)), errors=str(len(row.died)))
        suite.set("skipped", str(len(row.missing)))
        for run in of_row:
            case = Tree.SubElement(suite, "testcase", classname=f"{name}.{row.name}", name=f"seed {run.seed}")
            if run.died:
                died = _NOT_XML.sub("\ufffd", run.died)
                Tree.SubElement(case, "error", message=died.splitlines()[0]).text = died
            elif run.is_missing:
                Tree.SubElement(case, "skipped", message="it was not run")
    expectations = [comparison for comparison in summary.comparisons if comparison.expect is not None]
    failed = sum(comparison.verdict == "otherwise" for comparison in expectations)
    skipped = sum(comparison.verdict in ("undecided", "incomplete") for comparison in expectations)
    suite = Tree.SubElement(suites, "testsuite", name="expected", tests=str(len(expectations)))
    suite.attrib |= {"failures": str(failed), "skipped": str(skipped)}
    for comparison in expectations:
        title = f"{comparison.first} {comparison.expect}" + (f" {comparison.second}" if comparison.second else "")
        case = Tree.SubElement(suite, "testcase", classname=f"{name}.expected", name=title)
        if comparison.verdict == "otherwise":
            Tree.SubElement(case, "failure", message="the runs contradict the expectation")
        elif comparison.verdict == "undecided":
            Tree.SubElement(case, "skipped", message="the runs do not decide it")
        elif comparison.verdict == "incomplete":
            Tree.SubElement(case, "skipped", message="some of the runs were not done")
    Tree.indent(suites)
    return Tree.tostring(suites, encoding="unicode", xml_declaration=True) + "\n"
