"""What a batch says, in sentences for who has not read the paper. Pure: a summary in, text out.

A sentence claims no more than the runs tell: a difference is told when its 95 % interval leaves out zero.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from intellwheels_experiments.batch.statistics import Interval
from intellwheels_experiments.batch.summary import Comparison, Line, Summary

_EXPECTED: Final = {"worse": "be worse than", "better": "be better than", "equivalent": "be as good as"}
_TOLD: Final = {
    "clearance": ("kept {} more room", "came {} nearer to something", 100.0, "cm", 1),
    "time": ("took {} longer", "took {} less", 1.0, "s", 1),
    "path": ("drove {} further", "drove {} less", 100.0, "cm", 0),
    "odometry_error": ("knew its place {} worse", "knew its place {} better", 100.0, "cm", 1),
}
"""How a positive and a negative difference of a measure is said, of what unit, and with how many digits."""


def sentences(summary: Summary) -> list[str]:
    """Return what the comparisons of a batch say, a sentence or two for each; none where nothing is compared."""
    lines = {line.name: line for line in summary.lines}
    return [_sentence(one, lines) for one in summary.comparisons]


def _sentence(one: Comparison, lines: dict[str, Line]) -> str:
    first = lines[one.first]
    if one.second is None:
        return _alone(one, first)
    second = lines[one.second]
    counts = f"{_count(first)} succeeded against {_count(second)}"
    claim = f"{first.title} was expected to {_EXPECTED[one.expect]} {second.title}" if one.expect in _EXPECTED else ""
    told = {
        "as expected": f"{claim}, and it was: {counts}.",
        "otherwise": f"{claim}. It was not: {counts}{_within(one)}.",
        "undecided": f"{claim}. By success these runs do not tell: {counts}.",
        "not asked": f"{first.title} beside {second.title}: {counts}.",
    }[one.verdict]
    return " ".join([told, *_further(one)])


def _within(one: Comparison) -> str:
    is_close = one.expect != "equivalent" and one.paired is not None and one.paired.equivalent
    return ", which is as good within the margin" if is_close else ""


def _alone(one: Comparison, line: Line) -> str:
    if one.verdict == "undecided":
        return f"{line.title} was expected to touch nothing. No run came to an end."
    if one.verdict == "as expected":
        return f"{line.title} touched nothing in {line.runs} runs, as expected."
    return f"{line.title} was expected to touch nothing. It touched something in {line.collided} of {line.runs} runs."


def _further(one: Comparison) -> Iterator[str]:
    told = []
    for name, (more, less, scale, unit, digits) in _TOLD.items():
        if name in one.differences:
            mean, interval = one.differences[name]
            if interval.low > 0.0 or interval.high < 0.0:
                size = f"{scale * abs(mean):.{digits}f} {unit} ({_interval(interval, scale, digits)})"
                told.append((more if mean > 0.0 else less).format(size))
    if told:
        head = ", ".join(told[:-1])
        yield f"Where both reached their place, the first {head + ' and ' if head else ''}{told[-1]}."


def _interval(interval: Interval, scale: float, digits: int) -> str:
    low, high = sorted(scale * abs(value) for value in interval)
    return f"{low:.{digits}f} to {high:.{digits}f}"


def _count(line: Line) -> str:
    return f"{line.succeeded} of {line.runs}"
