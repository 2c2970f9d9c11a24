"""Measures of a run by their published definitions. Pure: arrays in, numbers out; no files, no network.

All measures use the true motion. Odometry is used only to measure its error. Arrays are float64[n], one value
per tick of the run, in metres, radians and seconds.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

SPARC_CUTOFF: Final = 10.0
"""Hz: the highest frequency that counts, from Balasubramanian et al. (2015)."""
SPARC_THRESHOLD: Final = 0.05
"""Share of the largest amplitude: the spectrum counts up to the last frequency that reaches it. Same source."""
SPARC_PADDING: Final = 4
"""Powers of two by which the Fourier transform is longer than the movement. Same source."""
DISAGREES: Final = 0.1
"""Share of full power by which the chair must deviate from the user's command to count as an intervention."""


def rising_edges(flags: Flags) -> int:
    """Return how often the flags turn true, counting a true first flag."""
    if not len(flags):
        return 0
    return int(flags[0]) + int(np.count_nonzero(flags[1:] & ~flags[:-1]))


def path_length(x: Floats, y: Floats) -> float:
    """Return the length of the path through the points, in m."""
    return float(np.hypot(np.diff(x), np.diff(y)).sum())


def success_weighted_by_path_length(success: bool, shortest: float, length: float) -> float:
    """Return the SPL of one run, in [0, 1]: the shortest path divided by the path driven; 0 without success.

    Args:
        success: Whether the run succeeded.
        shortest: The length of the shortest path, in m, greater than 0.
        length: The length of the path driven, in m.

    Source:
        Anderson et al. (2018), On evaluation of embodied navigation agents, arXiv:1807.06757. A batch's SPL is the
        mean over its runs.
    """
    return shortest / max(shortest, length) if success else 0.0


def log_dimensionless_jerk(speed: Floats, period: float) -> float:
    """Return the LDLJ of a movement: -ln(D^3 / v_peak^2 times the integral of (d2v/dt2)^2). Greater is smoother.

    The smoothest movement from rest to rest has -ln 204.8 = -5.322. The value is NaN for a movement without speed or
    without jerk, as at constant speed.

    It counts the duration: with the same start and the same stop, and more time at constant speed between, it falls
    by 3 ln of the ratio of the durations. So it says nothing without the time beside it.

    Args:
        speed: The speed from the start of the movement to its end, in m/s.
        period: The time between samples, in s.

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
    """Return the SPARC of a movement: minus the arc length of its normalised amplitude spectrum. Greater is smoother.

    The spectrum counts up to 10 Hz and up to the last frequency that has 5 % of the largest amplitude. The value is NaN
    for a movement without speed.

    Args:
        speed: The speed from the start of the movement to its end, in m/s.
        period: The time between samples, in s; at most 0.05, so that the spectrum reaches 10 Hz.

    Source:
        Balasubramanian et al. (2015), as above, equation 9 and the values it recommends.
    """
    if not np.any(speed):
        return math.nan
    size = int(2 ** (math.ceil(math.log2(len(speed))) + SPARC_PADDING))
    frequency = np.fft.rfftfreq(size, period)
    amplitude = np.abs(np.fft.rfft(speed, size))
    amplitude = (amplitude / amplitude.max())[frequency <= SPARC_CUTOFF + 1e-9]
    loud = np.nonzero(amplitude >= SPARC_THRESHOLD)[0]
    counted = slice(int(loud[0]), int(loud[-1]) + 1)
    selected, height = frequency[: len(amplitude)][counted], amplitude[counted]
    band = float(selected[-1] - selected[0])
    if band == 0.0:
        return math.nan
    return -float(np.hypot(np.diff(selected) / band, np.diff(height)).sum())


def moving(speed: Floats, turn_rate: Floats) -> slice:
    """Return the slice of a run that is movement: from the first tick with motion to the last."""
    ticks = np.nonzero((np.abs(speed) > 1e-3) | (np.abs(turn_rate) > 1e-3))[0]
    return slice(int(ticks[0]), int(ticks[-1]) + 1) if len(ticks) else slice(0, 0)


def user_effort(forward: Floats, turn: Floats) -> float:
    """Return how much a joystick was moved: the length of its path, in units of full deflection.

    It is the sum over ticks of hypot(change of forward, change of turn), starting from rest. The definition is this
    project's own. Joystick variation is a common measure of effort in work on shared control, for example in Urdiales
    et al. (2011), A new multi-criteria optimization strategy for shared control in wheelchair assisted navigation,
    Autonomous Robots 30.
    """
    return float(np.hypot(np.diff(forward, prepend=0.0), np.diff(turn, prepend=0.0)).sum())


def agreement(wanted: Floats, done: Floats) -> float:
    """Return how well the motors followed the direction of the user's command, in [0, 1]; NaN if there was none.

    It is 1 - |angle| / pi, averaged over the ticks with a command. The angle is between the command and the motors'
    motion, both as vectors of forward and turn; a tick without motion counts 0. The definition is this project's own,
    after an idea of Urdiales et al. (2011), cited above: to measure how far user and chair agree on the direction.

    Args:
        wanted: The user's command, float64[n, 2]: forward and turn.
        done: What the motors got, float64[n, 2]: forward and turn.
    """
    commanded = np.hypot(wanted[:, 0], wanted[:, 1]) > 1e-6
    if not commanded.any():
        return math.nan
    want, did = wanted[commanded], done[commanded]
    angle = np.arctan2(want[:, 1], want[:, 0]) - np.arctan2(did[:, 1], did[:, 0])
    off = np.abs(np.angle(np.exp(1j * angle))) / math.pi
    return float(np.where(np.hypot(did[:, 0], did[:, 1]) > 1e-6, 1.0 - off, 0.0).mean())


def interventions(wanted: Floats, done: Floats) -> int:
    """Return how often the chair began to deviate from its user's command by more than a tenth of full power.

    Args:
        wanted: The user's command, float64[n, 2]: forward and turn.
        done: What the motors got, float64[n, 2]: forward and turn.
    """
    return rising_edges(np.abs(wanted - done).max(axis=1, initial=0.0) > DISAGREES)


def drift_band(length: Floats, variance: float, track: float) -> tuple[Floats, Floats]:
    """Return the standard deviations of odometry on a straight path: of the heading in rad, of the lateral error in m.

    Only the random errors of the wheels count, no systematic ones.

    Args:
        length: L, the distance driven, in m.
        variance: k, the variance of each wheel's distance per metre, in m.
        track: b, the distance between the wheels, in m.

    Source:
        sd(heading) = sqrt(2 k L) / b and sd(y) = sqrt(2 k L^3 / 3) / b: the heading is a sum of independent errors, y
        its integral.
    """
    return np.sqrt(2.0 * variance * length) / track, np.sqrt(2.0 * variance * length**3 / 3.0) / track


def umbmark(left: Floats, right: Floats, side: float, track: float) -> tuple[float, float]:
    """Return the odometry calibration that follows from squares driven by odometry: the factors E_d and E_b.

    E_d is the right wheel's diameter divided by the left wheel's, E_b the true track divided by the nominal one.

    Args:
        left: True end minus end by odometry, float64[n, 2]: x and y in m, after squares to the left that start at the
            origin along x.
        right: The same after squares to the right.
        side: The side of the square, in m.
        track: The nominal track, in m.

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
