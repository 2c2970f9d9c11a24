"""Measures of a run by their published definitions. Pure: arrays in, numbers out; no files, no network.

Everything is measured on what was true; what the chair believed enters only where the error of that belief is meant.
Arrays are float64[n] over the ticks of the run, equally spaced in time; metres, radians, seconds.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

SPARC_CUTOFF: Final = 10.0
"""Hz: the highest frequency that counts, by Balasubramanian et al. (2015)."""
SPARC_THRESHOLD: Final = 0.05
"""Share of the greatest amplitude below which the spectrum's end does not count, by the same."""
SPARC_PADDING: Final = 4
"""Powers of two by which the transform is longer than the movement, by the same."""
DISAGREES: Final = 0.1
"""Share of full power by which what was done must differ from what was wanted to be an intervention."""


def rising_edges(flags: Flags) -> int:
    """Return how often something began: true where the tick before was not, or at the first tick."""
    if not len(flags):
        return 0
    return int(flags[0]) + int(np.count_nonzero(flags[1:] & ~flags[:-1]))


def path_length(x: Floats, y: Floats) -> float:
    """Return the length of a path through points, m."""
    return float(np.hypot(np.diff(x), np.diff(y)).sum())


def success_weighted_by_path_length(success: bool, shortest: float, length: float) -> float:
    """Return SPL of one run, in [0, 1]: success times shortest way over the way driven.

    Args:
        success: Whether it got there as it should.
        shortest: The shortest way there is, m, greater than 0.
        length: The way that was driven, m.

    Source:
        Anderson et al. (2018), On evaluation of embodied navigation agents, arXiv:1807.06757. A batch's SPL is the
        mean over its runs.
    """
    return shortest / max(shortest, length) if success else 0.0


def log_dimensionless_jerk(speed: Floats, period: float) -> float:
    """Return LDLJ of a movement: -ln(D^3 / v_peak^2 times the integral of (d2v/dt2)^2). Greater is smoother.

    The least jerky movement from rest to rest has -ln 204.8 = -5.322. A movement without speed, or at constant speed
    (no jerk at all), has none: NaN.

    Args:
        speed: Of the movement from its begin to its end, m/s.
        period: Between samples, s.

    Source:
        Balasubramanian, Melendez-Calderon, Roby-Brami and Burdet (2015), On the analysis of movement smoothness,
        Journal of NeuroEngineering and Rehabilitation 12:112.
    """
    peak = float(np.abs(speed).max(initial=0.0))
    if len(speed) < 3 or peak == 0.0:
        return math.nan
    jerk = np.diff(speed, 2) / period**2
    duration = len(speed) * period
    dimensionless = duration**3 / peak**2 * float((jerk**2).sum()) * period
    return -math.log(dimensionless) if dimensionless > 0.0 else math.nan


def spectral_arc_length(speed: Floats, period: float) -> float:
    """Return SPARC of a movement: minus the length of its normalised amplitude spectrum. Greater is smoother.

    The spectrum counts up to 10 Hz and up to the last frequency with 5 % of its greatest amplitude. A movement
    without speed has none: NaN.

    Args:
        speed: Of the movement from its begin to its end, m/s.
        period: Between samples, s; at most 0.05, for 10 Hz to be within the spectrum.

    Source:
        Balasubramanian et al. (2015), as above, equation 9 and the values it recommends.
    """
    if not np.any(speed):
        return math.nan
    size = int(2 ** (math.ceil(math.log2(len(speed))) + SPARC_PADDING))
    frequency = np.fft.rfftfreq(size, period)
    amplitude = np.abs(np.fft.rfft(speed, size))
    amplitude = (amplitude / amplitude.max())[frequency <= SPARC_CUTOFF + 1e-9]
    kept = np.nonzero(amplitude >= SPARC_THRESHOLD)[0]
    shown = slice(int(kept[0]), int(kept[-1]) + 1)
    selected, height = frequency[: len(amplitude)][shown], amplitude[shown]
    band = float(selected[-1] - selected[0])
    if band == 0.0:
        return math.nan
    return -float(np.hypot(np.diff(selected) / band, np.diff(height)).sum())


def moving(speed: Floats, turn_rate: Floats) -> slice:
    """Return the movement in a run: from the first tick that moves to the last."""
    ticks = np.nonzero((np.abs(speed) > 1e-3) | (np.abs(turn_rate) > 1e-3))[0]
    return slice(int(ticks[0]), int(ticks[-1]) + 1) if len(ticks) else slice(0, 0)


def user_effort(forward: Floats, turn: Floats) -> float:
    """Return how much a joystick was moved about: the length of its way, in units of full deflection.

    The definition is this project's: the sum over ticks of hypot(change of forward, change of turn), from rest. It is
    no paper's number; joystick variation as a measure of effort is common in work on shared control, as in Urdiales
    et al. (2011), A new multi-criteria optimization strategy for shared control in wheelchair assisted navigation,
    Autonomous Robots 30.
    """
    return float(np.hypot(np.diff(forward, prepend=0.0), np.diff(turn, prepend=0.0)).sum())


def agreement(wanted: Floats, done: Floats) -> float:
    """Return how far what was done pointed where the user wanted, in [0, 1]; NaN where nothing was ever wanted.

    It is 1 - |angle| / pi, averaged over the ticks at which something was wanted; where nothing is done then, it is 0.
    The angle is between the two as vectors of forward and turn. The definition is this project's, after the idea of
    Urdiales et al. (2011), as above, to measure how far user and chair point the same way; it is no paper's number.

    Args:
        wanted: float64[n, 2], forward and turn of the user.
        done: float64[n, 2], forward and turn that the motors got.
    """
    asked = np.hypot(wanted[:, 0], wanted[:, 1]) > 1e-6
    if not asked.any():
        return math.nan
    want, did = wanted[asked], done[asked]
    angle = np.arctan2(want[:, 1], want[:, 0]) - np.arctan2(did[:, 1], did[:, 0])
    off = np.abs(np.angle(np.exp(1j * angle))) / math.pi
    return float(np.where(np.hypot(did[:, 0], did[:, 1]) > 1e-6, 1.0 - off, 0.0).mean())


def interventions(wanted: Floats, done: Floats) -> int:
    """Return how often the chair began to do other than its user wanted, by more than a tenth of full power.

    Args:
        wanted: float64[n, 2], forward and turn of the user.
        done: float64[n, 2], forward and turn that the motors got.
    """
    return rising_edges(np.abs(wanted - done).max(axis=1, initial=0.0) > DISAGREES)


def drift_band(length: Floats, variance: float, track: float) -> tuple[Floats, Floats]:
    """Return by what odometry without systematic error errs after a way straight on: sd of heading, rad, and aside, m.

    Args:
        length: The way, m.
        variance: k, of a metre of each wheel, m.
        track: b, between the wheels, m.

    Source:
        sd(heading) = sqrt(2 k L) / b and sd(y) = sqrt(2 k L^3 / 3) / b: the heading is a sum of independent errors, y
        its integral.
    """
    return np.sqrt(2.0 * variance * length) / track, np.sqrt(2.0 * variance * length**3 / 3.0) / track


def umbmark(left: Floats, right: Floats, side: float, track: float) -> tuple[float, float]:
    """Return what squares driven by odometry tell of a chair's wheels: E_d, right wheel over left one, and E_b.

    Args:
        left: float64[n, 2], where the chair truly ended less where its odometry says, x and y, m, after squares to the
            left from the origin along x.
        right: The same after squares to the right.
        side: Of the square, m.
        track: Nominal, m.

    Source:
        Borenstein and Feng (1996), Measurement and correction of systematic odometry errors in mobile robots, IEEE
        Transactions on Robotics and Automation 12(6), equations 11 to 20, from the centres of gravity in x.
    """
    ccw, cw = float(left[:, 0].mean()), float(right[:, 0].mean())
    alpha = (cw + ccw) / (-4.0 * side)
    beta = (cw - ccw) / (-4.0 * side)
    radius = (side / 2.0) / math.sin(beta / 2.0) if beta else math.inf
    ratio = (radius + track / 2.0) / (radius - track / 2.0) if math.isfinite(radius) else 1.0
    return ratio, (math.pi / 2.0) / (math.pi / 2.0 - alpha)
