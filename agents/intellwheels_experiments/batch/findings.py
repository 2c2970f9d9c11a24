"""The findings of a batch in plain sentences. Pure: a summary in, text out.

A sentence claims no more than the runs show: it mentions a difference only if its 95 % interval excludes zero.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from intellwheels_experiments.batch.statistics import Interval
from intellwheels_experiments.batch.summary import Comparison, RowSummary, Summary

_EXPECTED: Final = {"worse": "do worse than", "better": "do better than", "equivalent": "do as well as"}
_DIFFERENCES: Final = {
    "clearance": ("kept {} more clearance", "kept {} less clearance", 100.0, "cm", 1),
    "time": ("took {} longer", "took {} less time", 1.0, "s", 1),
    "path": ("drove {} further", "drove {} less", 100.0, "cm", 0),
    "odometry_error": ("had {} more odometry error", "had {} less odometry error", 100.0, "cm", 1),
}
"""By measure: the words for a positive and a negative difference, the scale to the unit, the unit, the decimals."""


_OF_TWO_RUNS: Final = {
    "time": ("took {} longer", "took {} less time", "took as long", 1.0, "s", 2),
    "path": ("drove {} further", "drove {} less", "drove as far", 1.0, "m", 2),
    "clearance": ("kept {} more clearance", "kept {} less clearance", "kept as much clearance", 100.0, "cm", 1),
}
"""By measure: the words for a positive, a negative and no difference, the scale to the unit, the unit, the decimals."""


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, which is in the plural unless the number is 1."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def sentences(summary: Summary) -> list[str]:
    """Return one or two sentences per comparison of a batch; an empty list if nothing is compared."""
    rows = {row.name: row for row in summary.lines}
    return [_sentence(comparison, rows) for comparison in summary.comparisons]


def _sentence(comparison: Comparison, rows: dict[str, RowSummary]) -> str:
    first = rows[comparison.first]
    if comparison.verdict == "incomplete":
        return _incomplete(first, rows[comparison.second or comparison.first])
    if comparison.second is None:
        return _single(comparison, first)
    second = rows[comparison.second]
    if comparison.expect is None and first.runs == second.runs == 1:
        return _of_two_runs(first, second)
    noun = "run" if first.runs == 1 else "runs"
    counts = f"{_count(first)} {noun} succeeded, against {_count(second)}"
    expected = _EXPECTED.get(comparison.expect or "", "")
    claim = f"{first.title} was expected to {expected} {second.title}"
    finding = {
        "as expected": f"{claim}, and it did: {counts}.",
        "otherwise": f"{claim}, but it did not: {counts}{_within_margin(comparison)}.",
        "undecided": f"{claim}. The success rates do not settle it: {counts}.",
        "not asked": f"{first.title} compared with {second.title}: {counts}.",
    }[comparison.verdict]
    return " ".join([finding, *_differences(comparison)])


def _incomplete(first: RowSummary, second: RowSummary) -> str:
    both = (first,) if first is second else (first, second)
    lacking = " and ".join(f"{counted(len(row.missing), 'run')} of {row.title}" for row in both if row.missing)
    verb = "was" if sum(len(row.missing) for row in both) == 1 else "were"
    what = f"{first.title} is not judged" if first is second else f"{first.title} is not compared with {second.title}"
    return f"{what}: {lacking} {verb} not done."


def _of_two_runs(first: RowSummary, second: RowSummary) -> str:
    """Return how a single run differs from another one, as a branch does from its parent."""
    outcomes = _outcome(first), _outcome(second)
    both = outcomes[0] if outcomes[0] == outcomes[1] else f"{outcomes[0]}, but the second one {outcomes[1]}"
    who = "Both runs" if outcomes[0] == outcomes[1] else "The first run"
    phrases = []
    for name, (more, less, same, scale, unit, digits) in _OF_TWO_RUNS.items():
        if name not in first.spread or name not in second.spread:
            continue
        one, other = (round(scale * row.spread[name].median, digits) for row in (first, second))
        words = more if one > other else less if one < other else same
        values = f"{one:.{digits}f} {unit}" + (f", not {other:.{digits}f} {unit}" if one != other else "")
        phrases.append(f"{words.format(f'{abs(one - other):.{digits}f} {unit}')} ({values})")
    listed = f" The first run {_listed(phrases)}." if phrases else ""
    return f"First run: {first.title}. Second run: {second.title}. {who} {both}.{listed}"


def _outcome(row: RowSummary) -> str:
    """Return what the single run of a row came to."""
    arrived = "reached the place" if row.reached else "did not reach the place"
    return f"{arrived} and touched {'something' if row.collided else 'nothing'}"


def _within_margin(comparison: Comparison) -> str:
    paired = comparison.paired
    close = comparison.expect != "equivalent" and paired is not None and paired.equivalent
    return ". The two are equivalent within the margin" if close else ""


def _single(comparison: Comparison, row: RowSummary) -> str:
    if comparison.verdict == "undecided":
        return f"{row.title} was expected to touch nothing, but no run finished."
    if comparison.verdict == "as expected":
        return f"{row.title} touched nothing in {counted(row.runs, 'run')}, as expected."
    return f"{row.title} was expected to touch nothing, but it did in {row.collided} of {counted(row.runs, 'run')}."


def _differences(comparison: Comparison) -> Iterator[str]:
    """Yield one sentence about the measures that differ, if any does."""
    phrases = []
    for name, (more, less, scale, unit, digits) in _DIFFERENCES.items():
        if name in comparison.differences:
            mean, interval = comparison.differences[name]
            if interval.low > 0.0 or interval.high < 0.0:
                size = f"{scale * abs(mean):.{digits}f} {unit} ({_interval(interval, scale, digits)})"
                phrases.append((more if mean > 0.0 else less).format(size))
    if phrases:
        yield f"In the runs in which both reached their place, the first {_listed(phrases)}."


def _listed(phrases: list[str]) -> str:
    *others, last = phrases
    return f"{', '.join(others)} and {last}" if others else last


def _interval(interval: Interval, scale: float, digits: int) -> str:
    low, high = sorted(scale * abs(value) for value in interval)
    return f"{low:.{digits}f} to {high:.{digits}f}"


def _count(row: RowSummary) -> str:
    return f"{row.succeeded} of {row.runs}"
