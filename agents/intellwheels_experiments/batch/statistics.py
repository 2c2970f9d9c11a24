"""What a batch of runs says about the truth behind it. Pure: counts and pairs in, intervals out.

Rows of a batch share their seeds, so two rows are compared seed by seed; nothing is compared as if it were independent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from scipy import optimize, stats

MARGIN: Final = 0.15
"""Difference of success up to which two rows are as good as each other: 15 points."""
CONFIDENCE: Final = 0.95


class Interval(NamedTuple):
    """From low to high."""

    low: float
    high: float


class Paired(NamedTuple):
    """Two rows compared by the success of the same seeds.

    Attributes:
        pairs: Seeds that both have.
        both: Succeeded in both.
        first_only: Succeeded in the first only.
        second_only: Succeeded in the second only.
        difference: First less second, as shares.
        interval: Of the difference, 95 %.
        p: Of McNemar's exact test, two-sided: how likely so uneven a split is if neither is better.
        equivalent: Whether the difference is within the margin, each way at 5 % (the 90 % interval is within it).
    """

    pairs: int
    both: int
    first_only: int
    second_only: int
    difference: float
    interval: Interval
    p: float
    equivalent: bool


def wilson(successes: int, trials: int, confidence: float = CONFIDENCE) -> Interval:
    """Return Wilson's score interval of a share; (0, 1) without trials.

    Source:
        Wilson (1927), Probable inference, the law of succession, and statistical inference, JASA 22.
    """
    if trials == 0:
        return Interval(0.0, 1.0)
    found = stats.binomtest(successes, trials).proportion_ci(confidence, method="wilson")
    return Interval(float(found.low), float(found.high))


def compare(first: Sequence[bool], second: Sequence[bool], margin: float = MARGIN) -> Paired:
    """Return two rows compared.

    Args:
        first: Success of each seed.
        second: Of the same seeds in the same order.
        margin: Of equivalence, a share.

    Raises:
        ValueError: They are not equally long, or empty.
    """
    counted = list(zip(first, second, strict=True))
    if not counted:
        raise ValueError("compare: expected at least one pair")
    first_only = sum(a and not b for a, b in counted)
    second_only = sum(b and not a for a, b in counted)
    narrow = difference_interval(first_only, second_only, len(counted), 0.90)
    return Paired(
        pairs=len(counted),
        both=sum(a and b for a, b in counted),
        first_only=first_only,
        second_only=second_only,
        difference=(first_only - second_only) / len(counted),
        interval=difference_interval(first_only, second_only, len(counted)),
        p=mcnemar(first_only, second_only),
        equivalent=-margin < narrow.low and narrow.high < margin,
    )


def mcnemar(first_only: int, second_only: int) -> float:
    """Return the two-sided p of McNemar's exact test; 1 without a discordant pair.

    Source:
        McNemar (1947), Psychometrika 12; exact by the binomial distribution of the discordant pairs.
    """
    discordant = first_only + second_only
    return 1.0 if discordant == 0 else float(stats.binomtest(first_only, discordant).pvalue)


def difference_interval(first_only: int, second_only: int, pairs: int, confidence: float = CONFIDENCE) -> Interval:
    """Return the score interval of a difference of paired shares.

    It is those differences that the score test does not reject. Without a discordant pair it still has a width,
    plus and minus z^2 / (n + z^2).

    Source:
        Tango (1998), Equivalence test and confidence interval for the difference in proportions for the paired-sample
        design, Statistics in Medicine 17.
    """
    z = float(stats.norm.ppf(0.5 + confidence / 2.0))
    seen = (first_only - second_only) / pairs

    def score(delta: float) -> float:
        return _tango(first_only, second_only, pairs, delta)

    edge = 1.0 - 1e-12
    low = -1.0 if score(-edge) < z else float(optimize.brentq(lambda d: score(d) - z, -edge, min(seen, edge)))
    high = 1.0 if score(edge) > -z else float(optimize.brentq(lambda d: score(d) + z, max(seen, -edge), edge))
    return Interval(low, high)


def _tango(b: int, c: int, n: int, delta: float) -> float:
    """Return the score of a difference; falls as the difference grows."""
    linear = -b - c + (2.0 * n - b + c) * delta
    free = -c * delta * (1.0 - delta)
    q = (math.sqrt(max(linear**2 - 8.0 * n * free, 0.0)) - linear) / (4.0 * n)
    spread = n * (2.0 * q + delta * (1.0 - delta))
    off = b - c - n * delta
    if spread <= 0.0:
        return 0.0 if off == 0.0 else math.copysign(math.inf, off)
    return off / math.sqrt(spread)


def mean_difference(first: Sequence[float], second: Sequence[float]) -> tuple[float, Interval]:
    """Return the mean of paired differences, first less second, and its 95 % interval by Student's t.

    Pairs with a NaN do not count; with fewer than two left the interval is (-inf, inf).

    Raises:
        ValueError: They are not equally long.
    """
    off = np.array([a - b for a, b in zip(first, second, strict=True)], dtype=np.float64)
    off = off[np.isfinite(off)]
    if len(off) < 2:
        return (float(off[0]) if len(off) else math.nan), Interval(-math.inf, math.inf)
    mean, width = float(off.mean()), float(stats.sem(off)) * float(stats.t.ppf(0.975, len(off) - 1))
    return mean, Interval(mean - width, mean + width)
