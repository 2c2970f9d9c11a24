"""Measures against their published reference values."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

from intellwheels_experiments.batch import metrics
from intellwheels_experiments.batch.trace_reader import rolled

RATES = (20.0, 50.0, 100.0)


def minimum_jerk(rate: float, seconds: float = 4.0, scale: float = 1.0) -> metrics.Floats:
    """The speed of the least jerky movement from rest to rest, Flash and Hogan (1985), at the middle of each sample."""
    u = (np.arange(round(rate * seconds)) + 0.5) / (rate * seconds)
    return np.asarray(scale * 30.0 * u**2 * (1.0 - u) ** 2 / seconds)


@functools.cache
def continuous_spectral_arc_length(seconds: float) -> float:
    """SPARC of that movement by integrals alone: nothing is sampled in time."""
    from scipy import integrate

    frequency = np.linspace(0.0, 10.0, 2_001)
    grid = np.linspace(0.0, 1.0, 1_001)
    shape = 30.0 * grid**2 * (1.0 - grid) ** 2
    amplitude = np.array(
        [abs(integrate.simpson(shape * np.exp(-2j * math.pi * f * seconds * grid), x=grid)) for f in frequency]
    )
    last = int(np.nonzero(amplitude >= 0.05)[0][-1])
    band = frequency[last]
    return -float(np.hypot(np.diff(frequency[: last + 1]) / band, np.diff(amplitude[: last + 1])).sum())


@pytest.mark.parametrize("rate", RATES)
def test_ldlj_of_the_least_jerky_movement_is_minus_ln_204_8(rate: float) -> None:
    # Differences of samples miss the two ends, where the jerk is greatest: an error that shrinks with the sample.
    found = metrics.log_dimensionless_jerk(minimum_jerk(rate), 1.0 / rate)
    assert found == pytest.approx(-math.log(204.8), abs=2.5 / rate)


@pytest.mark.xdist_group("spectrum")  # which takes longer than all else here, and is cached
@pytest.mark.parametrize("rate", RATES)
def test_sparc_of_the_least_jerky_movement_is_that_of_its_continuous_spectrum(rate: float) -> None:
    found = metrics.spectral_arc_length(minimum_jerk(rate), 1.0 / rate)
    assert found == pytest.approx(continuous_spectral_arc_length(4.0), abs=0.01)
    assert -1.5 < found < -1.35


@pytest.mark.parametrize("rate", RATES)
def test_smoothness_depends_on_neither_size_nor_a_stop_in_between_less_than_it_should(rate: float) -> None:
    once = minimum_jerk(rate, 3.0)
    twice = np.concatenate([once, np.zeros(round(rate)), once])
    for measure in (metrics.log_dimensionless_jerk, metrics.spectral_arc_length):
        assert measure(5.0 * once, 1.0 / rate) == pytest.approx(measure(once, 1.0 / rate), abs=1e-12)
        assert measure(twice, 1.0 / rate) < measure(once, 1.0 / rate) - 0.3


def test_ldlj_counts_the_duration_and_sparc_hardly_does() -> None:
    # The same start and stop, of a second each, with 8 and with 18 s at constant speed between.
    share = np.linspace(0.0, 1.0, 21)
    start = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    short, long = (np.concatenate([start, np.ones(ticks), start[::-1]]) for ticks in (160, 360))
    jerk = [metrics.log_dimensionless_jerk(speed, 0.05) for speed in (short, long)]
    assert jerk[0] - jerk[1] == pytest.approx(3.0 * math.log(len(long) / len(short)), abs=1e-9)
    arc = [metrics.spectral_arc_length(speed, 0.05) for speed in (short, long)]
    assert 0.0 < arc[0] - arc[1] < 0.1 * (jerk[0] - jerk[1])


def test_what_does_not_move_has_no_smoothness() -> None:
    still = np.zeros(40)
    assert math.isnan(metrics.log_dimensionless_jerk(still, 0.05))
    assert math.isnan(metrics.spectral_arc_length(still, 0.05))
    assert math.isnan(metrics.log_dimensionless_jerk(np.ones(40), 0.05))


def test_contacts_count_where_they_begin() -> None:
    assert metrics.rising_edges(np.array([1, 1, 0, 1, 0, 0, 1, 1], dtype=bool)) == 3
    assert metrics.rising_edges(np.array([], dtype=bool)) == 0


def test_spl_is_the_share_of_the_shortest_way_and_nothing_without_success() -> None:
    assert metrics.success_weighted_by_path_length(True, 15.0, 20.0) == pytest.approx(0.75)
    assert metrics.success_weighted_by_path_length(True, 15.0, 14.9) == 1.0
    assert metrics.success_weighted_by_path_length(False, 15.0, 15.0) == 0.0


def test_path_is_as_long_as_its_pieces() -> None:
    assert metrics.path_length(np.array([0.0, 3.0, 3.0]), np.array([0.0, 4.0, 6.0])) == pytest.approx(7.0)


def test_effort_is_the_way_of_the_stick() -> None:
    forward = np.array([0.0, 1.0, 1.0, 0.0])
    turn = np.array([0.0, 0.0, -0.5, 0.0])
    assert metrics.user_effort(forward, turn) == pytest.approx(1.0 + 0.5 + math.hypot(1.0, 0.5))


def test_agreement_is_by_the_angle_between_wish_and_deed() -> None:
    wanted = np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 0.0], [1.0, 0.0]])
    done = np.array([[0.5, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
    assert metrics.agreement(wanted, done) == pytest.approx((1.0 + 0.5 + 0.0) / 3.0)
    assert math.isnan(metrics.agreement(np.zeros((3, 2)), done[:3]))


def test_intervention_begins_where_the_deed_leaves_the_wish() -> None:
    wanted = np.ones((6, 2)) * 0.5
    done = wanted.copy()
    done[2:4, 0] = 0.0
    done[5, 1] = 0.45
    assert metrics.interventions(wanted, done) == 1


def test_movement_is_from_the_first_moving_tick_to_the_last() -> None:
    speed = np.array([0.0, 0.0, 0.5, 0.0, 0.5, 0.0])
    assert metrics.moving(speed, np.zeros(6)) == slice(2, 5)
    assert metrics.moving(np.zeros(4), np.zeros(4)) == slice(0, 0)


def test_drift_band_is_what_independent_errors_of_the_wheels_add_up_to() -> None:
    # 4,000 ways of 15 m in steps of 0.1 m: the sd of a sample's sd is 1 / sqrt(8,000), 1.1 %.
    variance, track, steps, step = 1e-5, 0.572, 150, 0.1
    random = np.random.default_rng(1)
    turn = np.diff(random.normal(0.0, math.sqrt(variance * step), (4000, steps, 2)), axis=2)[..., 0] / track
    heading = np.cumsum(turn, axis=1)
    aside = np.sum(step * (heading - turn / 2.0), axis=1)
    of_heading, of_aside = metrics.drift_band(np.array([steps * step]), variance, track)
    assert heading[:, -1].std() == pytest.approx(of_heading[0], rel=0.05)
    assert aside.std() == pytest.approx(of_aside[0], rel=0.05)


@pytest.mark.parametrize(("ratio", "track_ratio"), [(1.002, 1.005), (0.997, 0.99), (1.0, 1.01), (1.003, 1.0)])
def test_squares_give_the_wheel_figures_back(ratio: float, track_ratio: float) -> None:
    track, side = 0.572, 4.0
    scale = np.array([2.0 / (1.0 + ratio), 2.0 * ratio / (1.0 + ratio)])
    ends = []
    for hand in (1.0, -1.0):
        turn = hand * math.pi / 2.0 * track / 2.0
        ways = np.array([[side, side], [-turn, turn]] * 4)
        ends.append(rolled(np.zeros(3), ways * scale, track * track_ratio)[-1:, :2])
    found = metrics.umbmark(ends[0], ends[1], side, track)
    # Its own linearisation errs by less than 1e-3 up to these figures.
    assert found == pytest.approx((ratio, track_ratio), abs=1e-3)
