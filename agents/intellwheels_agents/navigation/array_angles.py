"""Sines and cosines of arrays of angles, from + - * / alone, which are the same on every machine.

Those of numpy differ in the last bit between processors, so a run would not repeat. Of numpy this package uses what
is rounded correctly or does not round, and sums in a fixed order (`cumsum`). Single numbers use `portable_math`.

Source: the kernels `k_sin.c` and `k_cos.c` of FDLIBM, Copyright (C) 1993 by Sun Microsystems, Inc., freely granted
provided that this notice is preserved.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_HALF_PI: Final = (1.5707963267341256, 6.077100506506192e-11)
"""Half of pi in two parts; products of the first with a few thousand quarter turns are exact."""
_TWO_OVER_PI: Final = 0.6366197723675814


def sines(angles: Floats) -> tuple[Floats, Floats]:
    """Return the sines and the cosines of angles of less than a thousand turns, rad."""
    turns = np.floor(angles * _TWO_OVER_PI + 0.5)
    x = (angles - turns * _HALF_PI[0]) - turns * _HALF_PI[1]
    z = x * x
    s = -1.9841269829857949e-4 + z * (2.7557313707070068e-6 + z * (-2.5050760253406863e-8 + z * 1.58969099521155e-10))
    near_sine = x + z * x * (-0.16666666666666632 + z * (0.00833333333332249 + z * s))
    c = 2.480158728947673e-5 + z * (-2.7557314351390663e-7 + z * (2.087572321298175e-9 + z * -1.1359647557788195e-11))
    near_cosine = 1.0 - 0.5 * z + z * z * (0.0416666666666666 + z * (-0.001388888888887411 + z * c))
    quarter = turns.astype(np.int64) & 3
    odd = (quarter & 1).astype(bool)
    sine, cosine = np.where(odd, near_cosine, near_sine), np.where(odd, near_sine, near_cosine)
    return np.where(quarter >= 2, -sine, sine), np.where((quarter == 1) | (quarter == 2), -cosine, cosine)


def wrapped_all(angles: Floats) -> Floats:
    """Return angles in [-pi, pi]."""
    return angles - math.tau * np.floor(angles / math.tau + 0.5)
