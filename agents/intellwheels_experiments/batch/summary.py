"""A batch summed up: a line for each row, a line for each comparison. Pure: runs in, numbers, JSON and JUnit out."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final, Literal, TypeAlias
from xml.etree import ElementTree as Tree

import msgspec
import numpy as np

from intellwheels_experiments.batch.experiment_rows import Row
from intellwheels_experiments.batch.run_measures import Measured
from intellwheels_experiments.batch.run_store import StoredRun
from intellwheels_experiments.batch.statistics import Interval, Paired, compare, mean_difference, wilson
from intellwheels_experiments.batch.umbmark import Squares
from intellwheels_schemas.messages import Compare, Experiment

_NOT_XML: Final = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 has no way to write."""
DECIDES: Final = 0.05
"""p below which one row is worse than another."""
SPREAD: Final = ("clearance", "time", "path", "spl", "ldlj", "sparc", "effort", "agreement", "odometry_error")
"""Measures that are told by their median and quartiles."""

DIFFERENCES: Final = ("clearance", "time", "path", "odometry_error")
"""Measures that two rows are compared by beside their success."""

Verdict: TypeAlias = Literal["as expected", "otherwise", "undecided", "not asked"]


class Spread(msgspec.Struct, frozen=True, kw_only=True):
    """A measure over the runs that have it."""

    runs: int
    median: float
    low: float
    high: float
    least: float
    most: float


class Line(msgspec.Struct, frozen=True, kw_only=True):
    """A row.

    Attributes:
        runs: Runs that came to an end.
        died: Seeds of those that did not.
        succeeded: Runs that reached their place and touched nothing.
        interval: Wilson's 95 % interval of that share.
        reached: Runs that reached their place.
        collided: Runs that touched something.
        physical: Contacts with what is really there, in all runs.
        virtual: Contacts with what a simulation alone has.
        spread: Of the other measures, by name.
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


class Comparison(msgspec.Struct, frozen=True, kw_only=True):
    """Two rows, or one alone, and what came of what was expected.

    Attributes:
        paired: Their successes compared; None of a row alone, or without a common seed.
        differences: Of further measures by name, first less second: the mean over the seeds that both reached their
            place with, and its interval.
    """

    first: str
    second: str | None
    expect: str | None
    verdict: Verdict
    paired: Paired | None = None
    differences: dict[str, tuple[float, Interval]] = msgspec.field(default_factory=dict)


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """A batch.

    Attributes:
        lines: Its rows.
        comparisons: What is expected of them.
        umbmark: The wheel figures that its squares tell, of an experiment that asks for them.
    """

    lines: tuple[Line, ...]
    comparisons: tuple[Comparison, ...]
    umbmark: Squares | None = None


def sum_up(rows: Sequence[Row], runs: Sequence[StoredRun], experiment: Experiment | None) -> Summary:
    """Return a batch summed up."""
    of_row = {row.name: [run for run in runs if run.row == row.name] for row in rows}
    lines = {row.name: _line(row, of_row[row.name]) for row in rows}
    # Of a batch of some rows only those comparisons are made that it has both rows of.
    asked = (
        [one for one in experiment.compare if {one.first, one.second or one.first} <= lines.keys()]
        if experiment
        else []
    )
    margin = experiment.margin if experiment else 0.0
    return Summary(
        lines=tuple(lines.values()),
        comparisons=tuple(_comparison(one, lines, of_row, margin) for one in asked),
    )


def _line(row: Row, runs: Sequence[StoredRun]) -> Line:
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
    return Line(
        name=row.name,
        title=row.title,
        runs=len(ended),
        died=tuple(run.seed for run in runs if run.measured is None),
        succeeded=succeeded,
        interval=wilson(succeeded, len(ended)),
        reached=sum(one.reached for one in ended),
        collided=sum(one.collided for one in ended),
        physical=sum(one.contacts_physical for one in ended),
        virtual=sum(one.contacts_virtual for one in ended),
        spread=spread,
    )


def _comparison(
    asked: Compare, lines: dict[str, Line], of_row: dict[str, list[StoredRun]], margin: float
) -> Comparison:
    if asked.second is None:
        line = lines[asked.first]
        verdict: Verdict = "undecided" if line.runs == 0 else "as expected" if line.collided == 0 else "otherwise"
        return Comparison(first=asked.first, second=None, expect=asked.expect, verdict=verdict)
    second = {run.seed: run.measured for run in of_row[asked.second]}
    pairs = [
        (run.measured, other)
        for run in of_row[asked.first]
        if run.measured is not None and (other := second.get(run.seed)) is not None
    ]
    if not pairs:
        verdict = "not asked" if asked.expect is None else "undecided"
        return Comparison(first=asked.first, second=asked.second, expect=asked.expect, verdict=verdict)
    paired = compare([a.success for a, _ in pairs], [b.success for _, b in pairs], margin)
    there = [(a, b) for a, b in pairs if a.reached and b.reached]
    return Comparison(
        first=asked.first,
        second=asked.second,
        expect=asked.expect,
        verdict=_verdict(asked.expect, paired, margin),
        paired=paired,
        differences={name: found for name in DIFFERENCES if (found := _difference(name, there)) is not None},
    )


def _difference(name: str, pairs: Sequence[tuple[Measured, Measured]]) -> tuple[float, Interval] | None:
    """Return how far a measure differs; None with fewer than two seeds whose runs both have it."""
    told = [(getattr(a, name), getattr(b, name)) for a, b in pairs]
    values = [pair for pair in told if None not in pair]
    return mean_difference(*zip(*values, strict=True)) if len(values) > 1 else None


def _verdict(expect: str | None, paired: Paired, margin: float) -> Verdict:
    if expect is None:
        return "not asked"
    differs = paired.p < DECIDES
    if expect == "equivalent":
        # What differs by more than the margin is not equivalent; what may or may not is not decided.
        apart = paired.interval.low > margin or paired.interval.high < -margin
        return "as expected" if paired.equivalent else "otherwise" if apart else "undecided"
    wanted = paired.difference < 0.0 if expect == "worse" else paired.difference > 0.0
    if differs:
        return "as expected" if wanted else "otherwise"
    # Within the margin there is no worse and no better that would matter.
    return "otherwise" if paired.equivalent else "undecided"


def to_json(summary: Summary) -> bytes:
    """Return a summary as indented JSON."""
    return msgspec.json.format(msgspec.json.encode(summary), indent=2) + b"\n"


def to_junit(name: str, summary: Summary, runs: Sequence[StoredRun]) -> str:
    """Return a batch as JUnit XML: a case for each run, an error where it died; a case for each thing expected."""
    suites = Tree.Element("testsuites", name=name)
    for line in summary.lines:
        here = [run for run in runs if run.row == line.name]
        suite = Tree.SubElement(suites, "testsuite", name=line.name, tests=str(len(here)), errors=str(len(line.died)))
        for run in here:
            case = Tree.SubElement(suite, "testcase", classname=f"{name}.{line.name}", name=f"seed {run.seed}")
            if run.died:
                died = _NOT_XML.sub("\ufffd", run.died)
                Tree.SubElement(case, "error", message=died.splitlines()[0]).text = died
    asked = [one for one in summary.comparisons if one.verdict != "not asked"]
    failed = sum(one.verdict == "otherwise" for one in asked)
    skipped = sum(one.verdict == "undecided" for one in asked)
    suite = Tree.SubElement(suites, "testsuite", name="expected", tests=str(len(asked)))
    suite.attrib |= {"failures": str(failed), "skipped": str(skipped)}
    for one in asked:
        title = f"{one.first} {one.expect}" + (f" {one.second}" if one.second else "")
        case = Tree.SubElement(suite, "testcase", classname=f"{name}.expected", name=title)
        if one.verdict == "otherwise":
            Tree.SubElement(case, "failure", message="it is otherwise")
        elif one.verdict == "undecided":
            Tree.SubElement(case, "skipped", message="these runs do not decide it")
    Tree.indent(suites)
    return Tree.tostring(suites, encoding="unicode", xml_declaration=True) + "\n"
