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


def sentences(summary: Summary) -> list[str]:
    """Return one or two sentences per comparison of a batch; an empty list if nothing is compared."""
    rows = {row.name: row for row in summary.lines}
    return [_sentence(comparison, rows) for comparison in summary.comparisons]


def _sentence(comparison: Comparison, rows: dict[str, RowSummary]) -> str:
    first = rows[comparison.first]
    if comparison.second is None:
        return _single(comparison, first)
    second = rows[comparison.second]
    counts = f"{_count(first)} runs succeeded, against {_count(second)}"
    expected = _EXPECTED.get(comparison.expect or "", "")
    claim = f"{first.title} was expected to {expected} {second.title}"
    finding = {
        "as expected": f"{claim}, and it did: {counts}.",
        "otherwise": f"{claim}, but it did not: {counts}{_within_margin(comparison)}.",
        "undecided": f"{claim}. The success rates do not settle it: {counts}.",
        "not asked": f"{first.title} compared with {second.title}: {counts}.",
    }[comparison.verdict]
    return " ".join([finding, *_differences(comparison)])


def _within_margin(comparison: Comparison) -> str:
    paired = comparison.paired
    close = comparison.expect != "equivalent" and paired is not None and paired.equivalent
    return ". The two are equivalent within the margin" if close else ""


def _single(comparison: Comparison, row: RowSummary) -> str:
    if comparison.verdict == "undecided":
        return f"{row.title} was expected to touch nothing, but no run finished."
    if comparison.verdict == "as expected":
        return f"{row.title} touched nothing in {row.runs} runs, as expected."
    return f"{row.title} was expected to touch nothing, but it did in {row.collided} of {row.runs} runs."


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
        *others, last = phrases
        listed = f"{', '.join(others)} and {last}" if others else last
        yield f"In the runs in which both reached their place, the first {listed}."


def _interval(interval: Interval, scale: float, digits: int) -> str:
    low, high = sorted(scale * abs(value) for value in interval)
    return f"{low:.{digits}f} to {high:.{digits}f}"


def _count(row: RowSummary) -> str:
    return f"{row.succeeded} of {row.runs}"
