"""Rounding of readings: what sensors report has at most six decimals, and no negative zero."""

from __future__ import annotations

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import Floats, Ints

# Beyond 2^52 / 1e6 a number has fewer than six binary decimals, so it stays as it is.
_MOST = 4503599627370496.0


@njit(cache=True, error_model="numpy", nogil=True)
def round_readings(spans: Ints, samples: Floats) -> None:
    """Round samples to 1e-6, half to even.

    Args:
        spans: int64[sensors, 2], the first sample of each sensor and the end of its samples, without its memory.
        samples: float64[...], changed in place.
    """
    for sensor in range(spans.shape[0]):
        for at in range(spans[sensor, 0], spans[sensor, 1]):
            scaled = samples[at] * 1e6
            if -_MOST < scaled < _MOST:
                # The sum turns -0.0 into 0.0.
                samples[at] = np.rint(scaled) / 1e6 + 0.0
