"""Noise of the motors: a factor on the output of each motor that is held for `HOLD` of simulated time.

    factor(t) = 1 + s n(floor(t / HOLD)),  n standard normal, independent for each interval and motor

It is white noise through a zero-order hold. An interval is one of simulated time, not a tick, so a run has the same
factors at the same times whatever its period. Its variance and its correlation time belong to the motor:

    spectral density at 0 = s^2 HOLD, that of an Ornstein-Uhlenbeck process of the same variance and a correlation
    time of HOLD / 2

So after L metres at a speed v each wheel has rolled with a standard deviation of s sqrt(HOLD v L). A process that is
held needs no memory in the state, where an Ornstein-Uhlenbeck process would need its last value.

Sources:
    Uhlenbeck, Ornstein (1930), On the theory of the Brownian motion, Physical Review 36(5).
    Gillespie (1996), Exact numerical simulation of the Ornstein-Uhlenbeck process and its integral, Physical Review E
    54(2): the long-time variance of the integral, which equals that of the held process.
    HOLD is chosen: the reference cycle of the paper, for which `MotorNoise` has always been stated.
"""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.noise import normal

HOLD = 0.05
"""Simulated time for which a factor is held, s."""

# Row of flaws: standard deviation of the output, as a share. `wheel_slip` has the others.
MOTOR_NOISE = 0
MOTOR_NOISE_ROWS = 1

# Share of an interval below which a time is at its edge: ticks of 0.01 s do not add up to 0.05 s in their last bits.
_EDGE = 1e-6


@njit(cache=True, error_model="numpy")
def interval_of(tick: int, period: float) -> float:
    """Return the time of a tick in units of `HOLD`; a whole number at the edge of an interval.

    Args:
        tick: The tick.
        period: Simulated time of a tick, s. At a period of `HOLD` the result is the tick.
    """
    time = tick * (period / HOLD)
    edge = np.floor(time + 0.5)
    return edge if abs(time - edge) < _EDGE else time


@njit(cache=True, error_model="numpy")
def noise_factor(flaws: Floats, keys: Ints, i: int, interval: int, motor: int) -> float:
    """Return the factor on the output of a motor.

    Args:
        flaws: float64[FLAW_ROWS, n].
        keys: int64[2, n], bits of the noise keys.
        i: The body.
        interval: Number of the interval, >= 0.
        motor: 0 for the left one, 1 for the right one.
    """
    deviation: float = flaws[MOTOR_NOISE, i] * normal(np.uint64(keys[0, i]), np.uint64(keys[1, i]), interval, motor)
    return 1.0 + deviation
