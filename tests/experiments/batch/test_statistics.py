"""Intervals and tests against published and exact values."""

from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_experiments.batch.statistics import compare, difference_interval, mcnemar, mean_difference, wilson


def test_wilson_interval_of_81_in_263_is_as_published() -> None:
    # Newcombe (1998), Statistics in Medicine 17:857, table I, method 3.
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)


def test_wilson_interval_of_nothing_is_everything() -> None:
    assert wilson(0, 0) == (0.0, 1.0)


def test_mcnemar_is_the_binomial_of_the_discordant_pairs() -> None:
    assert mcnemar(0, 0) == 1.0
    assert mcnemar(6, 0) == pytest.approx(2.0 / 2**6)
    assert mcnemar(1, 5) == pytest.approx(2.0 * (1 + 6) / 2**6)


def test_intervals_and_p_values_are_those_of_scipy() -> None:
    from scipy import stats  # takes half a second; most workers do not need it

    for trials in (1, 2, 7, 40, 263, 2000):
        for successes in {0, 1, trials // 3, trials // 2, trials - 1, trials}:
            found = stats.binomtest(successes, trials)
            assert wilson(successes, trials) == tuple(found.proportion_ci(0.95, method="wilson"))
            assert mcnemar(successes, trials - successes) == pytest.approx(found.pvalue, rel=1e-12)
    values = np.random.default_rng(3).normal(size=9)
    width = stats.sem(values) * stats.t.ppf(0.975, 8)
    mean = float(values.mean())
    assert mean_difference(list(values), [0.0] * 9) == (mean, (mean - width, mean + width))


def test_difference_without_discordant_pairs_still_has_a_width() -> None:
    z2 = 1.959963984540054**2
    assert difference_interval(0, 0, 40) == pytest.approx((-z2 / (40 + z2), z2 / (40 + z2)))


def test_difference_interval_mirrors_when_the_rows_are_swapped() -> None:
    low, high = difference_interval(7, 1, 40)
    assert difference_interval(1, 7, 40) == pytest.approx((-high, -low))


def restricted_score(b: int, c: int, n: int, delta: float) -> float:
    """The score of a difference, the likeliest shares under it found by search rather than by formula."""
    from scipy import optimize

    def unlikely(c_share: float) -> float:
        shares = (c_share + delta, c_share, 1.0 - 2.0 * c_share - delta)
        return -sum(k * math.log(max(share, 1e-300)) for k, share in zip((b, c, n - b - c), shares, strict=True) if k)

    low, high = max(0.0, -delta), (1.0 - delta) / 2.0
    found = optimize.minimize_scalar(unlikely, bounds=(low, high), method="bounded", options={"xatol": 1e-12})
    variance = (2.0 * found.x + delta - delta**2) * n
    return (b - c - n * delta) / math.sqrt(variance)


@pytest.mark.parametrize(("b", "c", "n"), [(0, 1, 44), (7, 1, 40), (14, 0, 40), (5, 5, 100), (10, 0, 10)])
def test_difference_interval_ends_where_the_score_test_rejects(b: int, c: int, n: int) -> None:
    for end, z in zip(difference_interval(b, c, n), (1.959964, -1.959964), strict=True):
        if abs(end) < 1.0:
            assert restricted_score(b, c, n, end) == pytest.approx(z, abs=1e-4)


def test_difference_of_everything_reaches_one() -> None:
    assert difference_interval(10, 0, 10).high == 1.0


def test_difference_interval_holds_the_truth_in_95_of_100_batches() -> None:
    # 4,000 batches: the sd of the share that is held is 0.35 points.
    random = np.random.default_rng(7)
    held = 0
    for b, c, _ in random.multinomial(40, (0.25, 0.1, 0.65), 4000):
        low, high = difference_interval(int(b), int(c), 40)
        held += low <= 0.15 <= high
    assert 0.935 < held / 4000 < 0.965


def test_rows_that_never_differ_are_equivalent_at_40_pairs_and_not_at_10() -> None:
    assert compare([True] * 40, [True] * 40).equivalent
    assert not compare([True] * 10, [True] * 10).equivalent


def test_rows_that_differ_often_are_compared_as_what_they_are() -> None:
    found = compare([True] * 40, [True] * 26 + [False] * 14)
    assert (found.both, found.first_only, found.second_only, found.difference) == (26, 14, 0, 0.35)
    assert found.p == pytest.approx(2.0 / 2**14)
    assert not found.equivalent
    assert found.interval.low > 0.15


def test_comparison_needs_pairs() -> None:
    with pytest.raises(ValueError, match="at least one pair"):
        compare([], [])


def test_mean_difference_is_of_pairs_that_both_have() -> None:
    mean, interval = mean_difference([3.0, 5.0, math.nan], [1.0, 2.0, 0.0])
    assert mean == pytest.approx(2.5)
    assert interval == pytest.approx((2.5 - 0.5 * 12.7062, 2.5 + 0.5 * 12.7062), abs=1e-3)
    assert mean_difference([1.0], [0.5])[1] == (-math.inf, math.inf)
