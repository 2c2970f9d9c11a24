"""Intervals and tests for a batch of runs. Pure: counts and pairs in, intervals out.

The rows of a batch share their seeds, so two rows are compared seed by seed and never as independent samples.
Quantiles come from `scipy.special`. It loads in a fraction of the second that `scipy.stats` takes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from scipy.special import ndtri, stdtrit

from intellwheels_schemas.messages import Experiment

MARGIN: Final = Experiment(subject="chair").margin
"""Largest difference of success rates that counts as equivalent, where an experiment does not set its own."""
CONFIDENCE: Final = 0.95


class Interval(NamedTuple):
    """An interval from `low` to `high`."""

    low: float
    high: float


class Paired(NamedTuple):
    """Two rows compared by the success of the same seeds.

    Attributes:
        pairs: Number of seeds that both rows have.
        both: Number of seeds that succeeded in both rows.
        first_only: Number of seeds that succeeded in the first row only.
        second_only: Number of seeds that succeeded in the second row only.
        difference: Success rate of the first row minus that of the second, in [-1, 1].
        interval: The 95 % interval of the difference.
        p: The p value of McNemar's exact test, two-sided: how likely such an uneven split is if neither is better.
        equivalent: Whether the difference is within the margin, at 5 % on each side: the 90 % interval is inside it.
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
    """Return Wilson's score interval of a success rate; (0, 1) without trials.

    Source:
        Wilson (1927), Probable inference, the law of succession, and statistical inference, JASA 22.
    """
    if trials == 0:
        return Interval(0.0, 1.0)
    z = float(ndtri(0.5 + confidence / 2.0))
    share = successes / trials
    scale = 2.0 * (trials + z**2)
    center = (2.0 * trials * share + z**2) / scale
    width = z / scale * math.sqrt(4.0 * trials * share * (1.0 - share) + z**2)
    return Interval(0.0 if successes == 0 else center - width, 1.0 if successes == trials else center + width)


def compare(first: Sequence[bool], second: Sequence[bool], margin: float = MARGIN) -> Paired:
    """Return the comparison of two rows.

    Args:
        first: The success of each seed in the first row.
        second: The same for the second row, with the same seeds in the same order.
        margin: The largest difference of success rates that counts as equivalent.

    Raises:
        ValueError: The sequences differ in length or are empty.
    """
    pairs = list(zip(first, second, strict=True))
    if not pairs:
        raise ValueError("compare: expected at least one pair")
    first_only = sum(a and not b for a, b in pairs)
    second_only = sum(b and not a for a, b in pairs)
    narrow = difference_interval(first_only, second_only, len(pairs), 0.90)
    return Paired(
        pairs=len(pairs),
        both=sum(a and b for a, b in pairs),
        first_only=first_only,
        second_only=second_only,
        difference=(first_only - second_only) / len(pairs),
        interval=difference_interval(first_only, second_only, len(pairs)),
        p=mcnemar(first_only, second_only),
        equivalent=-margin < narrow.low and narrow.high < margin,
    )


def mcnemar(first_only: int, second_only: int) -> float:
    """Return the two-sided p value of McNemar's exact test; 1 without a discordant pair.

    Source:
        McNemar (1947), Psychometrika 12; made exact by the binomial distribution of the discordant pairs.
    """
    discordant = first_only + second_only
    tail = sum(math.comb(discordant, count) for count in range(min(first_only, second_only) + 1))
    return min(1.0, 2 * tail / (1 << discordant))


def difference_interval(first_only: int, second_only: int, pairs: int, confidence: float = CONFIDENCE) -> Interval:
    """Return the score interval of a difference of paired success rates.

    The interval holds the differences that the score test does not reject. Without a discordant pair it still extends
    to plus and minus z^2 / (n + z^2).

    Source:
        Tango (1998), Equivalence test and confidence interval for the difference in proportions for the paired-sample
        design, Statistics in Medicine 17.
    """
    from scipy import optimize  # noqa: PLC0415 - only rows that are compared need it

    z = float(ndtri(0.5 + confidence / 2.0))
    observed = (first_only - second_only) / pairs

    def score(delta: float) -> float:
        return _tango(first_only, second_only, pairs, delta)

    edge = 1.0 - 1e-12
    low = -1.0 if score(-edge) < z else float(optimize.brentq(lambda d: score(d) - z, -edge, min(observed, edge)))
    high = 1.0 if score(edge) > -z else float(optimize.brentq(lambda d: score(d) + z, max(observed, -edge), edge))
    return Interval(low, high)


def _tango(b: int, c: int, n: int, delta: float) -> float:
    """Return the score of a difference `delta`. It falls as `delta` grows."""
    linear = -b - c + (2.0 * n - b + c) * delta
    free = -c * delta * (1.0 - delta)
    q = (math.sqrt(max(linear**2 - 8.0 * n * free, 0.0)) - linear) / (4.0 * n)
    spread = n * (2.0 * q + delta * (1.0 - delta))
    off = b - c - n * delta
    if spread <= 0.0:
        return 0.0 if off == 0.0 else math.copysign(math.inf, off)
    return off / math.sqrt(spread)


def mean_difference(first: Sequence[float], second: Sequence[float]) -> tuple[float, Interval]:
    """Return the mean of paired differences, first minus second, and its 95 % interval by Student's t.

    Pairs with a NaN do not count. With fewer than two pairs the interval is (-inf, inf).

    Raises:
        ValueError: The sequences differ in length.
    """
    differences = np.array([a - b for a, b in zip(first, second, strict=True)], dtype=np.float64)
    differences = differences[np.isfinite(differences)]
    count = len(differences)
    if count < 2:
        return (float(differences[0]) if count else math.nan), Interval(-math.inf, math.inf)
    mean, error = float(differences.mean()), float(differences.std(ddof=1)) / math.sqrt(count)
    width = error * float(stdtrit(count - 1, 0.975))
    return mean, Interval(mean - width, mean + width)
