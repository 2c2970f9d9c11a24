"""Sine, cosine and direction of a vector from + - * / and sqrt alone, which are the same on every machine.

Those of the C library and of numpy differ in the last bit between processors, so a run would not repeat. All angles of
the package `navigation` pass through this file.

Source: the kernels `k_sin.c`, `k_cos.c` and `s_atan.c` of FDLIBM, Copyright (C) 1993 by Sun Microsystems, Inc., freely
granted provided that this notice is preserved.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

PI: Final = 3.141592653589793
TWO_PI: Final = 6.283185307179586
_HALF_PI: Final = (1.5707963267341256, 6.077100506506192e-11)
_TWO_OVER_PI: Final = 0.6366197723675814


def sines(angles: Floats) -> tuple[Floats, Floats]:
    """Return the sines and the cosines of angles, rad."""
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


def sine_cosine(angle: float) -> tuple[float, float]:
    """Return the sine and the cosine of an angle, rad; bit for bit those of `sines`."""
    turns = (angle * _TWO_OVER_PI + 0.5) // 1.0
    x = (angle - turns * _HALF_PI[0]) - turns * _HALF_PI[1]
    z = x * x
    s = -1.9841269829857949e-4 + z * (2.7557313707070068e-6 + z * (-2.5050760253406863e-8 + z * 1.58969099521155e-10))
    sine = x + z * x * (-0.16666666666666632 + z * (0.00833333333332249 + z * s))
    c = 2.480158728947673e-5 + z * (-2.7557314351390663e-7 + z * (2.087572321298175e-9 + z * -1.1359647557788195e-11))
    cosine = 1.0 - 0.5 * z + z * z * (0.0416666666666666 + z * (-0.001388888888887411 + z * c))
    quarter = int(turns) & 3
    if quarter & 1:
        sine, cosine = cosine, sine
    return (-sine if quarter >= 2 else sine), (-cosine if quarter in (1, 2) else cosine)


_ATAN_HIGH: Final = (0.4636476090008061, 0.7853981633974483, 0.982793723247329, 1.5707963267948966)
_ATAN: Final = (
    0.3333333333333293, -0.19999999999876483, 0.14285714272503466, -0.11111110405462356, 0.09090887133436507,
    -0.0769187620504483, 0.06661073137387531, -0.058335701337905735, 0.049768779946159324, -0.036531572744216916,
    0.016285820115365782,
)  # fmt: skip


def direction(y: float, x: float) -> float:
    """Return the angle of the vector (x, y), in (-pi, pi]; 0 for the null vector."""
    if x == 0.0 and y == 0.0:
        return 0.0
    if abs(y) <= abs(x):
        angle = _arc_tangent(abs(y) / abs(x))
    else:
        angle = _ATAN_HIGH[3] - _arc_tangent(abs(x) / abs(y))
    if x < 0.0:
        angle = PI - angle
    return -angle if y < 0.0 else angle


def _arc_tangent(t: float) -> float:
    """Return the arc tangent of t in [0, 1]."""
    base = 0.0
    if t >= 0.6875:
        base, t = _ATAN_HIGH[1], (t - 1.0) / (t + 1.0)
    elif t >= 0.4375:
        base, t = _ATAN_HIGH[0], (2.0 * t - 1.0) / (2.0 + t)
    z = t * t
    total = 0.0
    for coefficient in reversed(_ATAN):
        total = coefficient + z * total
    return base + (t - t * z * total)


def wrapped(angle: float) -> float:
    """Return the angle in (-pi, pi]."""
    turned = angle - TWO_PI * ((angle / TWO_PI + 0.5) // 1.0)
    return turned if turned > -PI else turned + TWO_PI


def wrapped_all(angles: Floats) -> Floats:
    """Return angles in [-pi, pi]."""
    return angles - TWO_PI * np.floor(angles / TWO_PI + 0.5)


def power_of(base: float, exponent: float) -> float:
    """Return base ** exponent for a base in [0, 1] and an exponent >= 0, to 2^-40 in the exponent."""
    if base <= 0.0:
        return 0.0 if exponent > 0.0 else 1.0
    whole = int(exponent)
    result = 1.0
    for _ in range(whole):
        result *= base
    rest, root = exponent - whole, base
    for _ in range(40):
        rest, root = rest * 2.0, root**0.5
        if rest >= 1.0:
            rest -= 1.0
            result *= root
    return result
