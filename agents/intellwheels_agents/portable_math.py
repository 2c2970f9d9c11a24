"""Sine, arc tangent, exponential and others that give the same bits on every machine and with every Python.

Those of `math` come from the C library, and differ in the last bit between processors and versions. After some hundred
ticks a run differs too. `hypot` and `dist` of `math`, and `sum` of floats, differ between versions of Python. Use the
functions here in a mind whose runs are to repeat anywhere. They are called like those of `math`, and have errors below
2 ulp (`power`: of the exponent times the logarithm). For sines, cosines and tangents this holds for angles up to 1e6;
beyond, the angle is reduced by the float `tau`. They use only operations that IEEE 754 rounds correctly.

These of `math` are the same everywhere: `sqrt`, `floor`, `ceil`, `trunc`, `copysign`, `fabs`, `fmod`, `remainder`,
`radians`, `degrees`, `fsum`, `isclose`, `isfinite`, `isinf`, `isnan`, `nextafter`, and the constants. Write `x * x`
instead of `x**2`, which is the C library's `pow`.

The simulator's world has the same functions, compiled, in `world/kernels/elementary.py`; a test compares their bits.

Source:
    Polynomials, thresholds and split constants of FDLIBM (`k_sin.c`, `k_cos.c`, `e_rem_pio2.c`, `s_atan.c`,
    `e_atan2.c`, `e_log.c`, `e_exp.c`), Copyright (C) 1993 by Sun Microsystems, Inc., freely granted provided
    that this notice is preserved.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from math import frexp, ldexp, sqrt
from typing import Final

_PI: Final = math.pi
# pi minus the float pi, for sums that must be correct in their last bit.
_PI_LOW: Final = 1.2246467991473532e-16
_QUARTER_PI: Final = 0.7853981633974483
# Beyond it the product of the quarter turns and the first part of pi/2 is no longer exact.
_LARGEST_ANGLE: Final = 1e6
_TWO_OVER_PI: Final = 0.6366197723675814
# pi/2 in pieces of 33 bits (head) and what is left (tail).
_HALF_PI_1, _HALF_PI_1_TAIL = 1.5707963267341256, 6.077100506506192e-11
_HALF_PI_2, _HALF_PI_2_TAIL = 6.077100506303966e-11, 2.0222662487959506e-21
_HALF_PI_3, _HALF_PI_3_TAIL = 2.0222662487111665e-21, 8.4784276603689e-32
_LN2_HIGH: Final = 0.6931471803691238
_LN2_LOW: Final = 1.9082149292705877e-10
_SQRT_2_SPLIT: Final = 1.0 + 0x6A09C00000000 / 2.0**52


def _far_remainder(x: float) -> tuple[int, float, float]:
    """Return the quarter turns in x modulo 4 and the rest, in [-pi/4, pi/4], as head and tail."""
    if not abs(x) <= _LARGEST_ANGLE:
        if math.isnan(x):
            return 0, x, x
        x = math.remainder(x, math.tau)
    turns = int(x * _TWO_OVER_PI + 0.5) if x >= 0.0 else -int(0.5 - x * _TWO_OVER_PI)
    rest = x - turns * _HALF_PI_1
    lost = turns * _HALF_PI_1_TAIL
    head = rest - lost
    if abs(head) < abs(x) * 1.52587890625e-05:
        # More than 16 bits cancelled: subtract 33 more bits of pi/2.
        before = rest
        lost = turns * _HALF_PI_2
        rest = before - lost
        lost = turns * _HALF_PI_2_TAIL - ((before - rest) - lost)
        head = rest - lost
        if abs(head) < abs(x) * 1.7763568394002505e-15:
            # More than 49 bits.
            before = rest
            lost = turns * _HALF_PI_3
            rest = before - lost
            lost = turns * _HALF_PI_3_TAIL - ((before - rest) - lost)
            head = rest - lost
    return turns & 3, head, (rest - head) - lost


def _near_sin(x: float, tail: float) -> float:
    """Return sin(x + tail) for |x| <= pi/4."""
    z = x * x
    w = z * z
    r = 0.00833333333332249 + z * (-0.0001984126982985795 + z * 2.7557313707070068e-06)
    r += z * w * (-2.5050760253406863e-08 + z * 1.58969099521155e-10)
    v = z * x
    return x - ((z * (0.5 * tail - v * r) - tail) - v * -0.16666666666666632)


def _near_cos(x: float, tail: float) -> float:
    """Return cos(x + tail) for |x| <= pi/4."""
    z = x * x
    w = z * z
    r = z * (0.0416666666666666 + z * (-0.001388888888887411 + z * 2.480158728947673e-05))
    r += w * w * (-2.7557314351390663e-07 + z * (2.087572321298175e-09 + z * -1.1359647557788195e-11))
    half = 0.5 * z
    w = 1.0 - half
    return w + (((1.0 - w) - half) + (z * r - x * tail))


def sin(x: float) -> float:
    """Return the sine of x radians."""
    if -_QUARTER_PI <= x <= _QUARTER_PI:
        return _near_sin(x, 0.0)
    quarter, head, tail = _far_remainder(x)
    value = _near_cos(head, tail) if quarter & 1 else _near_sin(head, tail)
    return -value if quarter & 2 else value


def cos(x: float) -> float:
    """Return the cosine of x radians."""
    if -_QUARTER_PI <= x <= _QUARTER_PI:
        return _near_cos(x, 0.0)
    quarter, head, tail = _far_remainder(x)
    value = _near_sin(head, tail) if quarter & 1 else _near_cos(head, tail)
    return -value if quarter in (1, 2) else value


def sincos(x: float) -> tuple[float, float]:
    """Return the sine and the cosine of x radians, faster than one after the other."""
    if -_QUARTER_PI <= x <= _QUARTER_PI:
        # `_near_sin` and `_near_cos` with tail 0, inlined: minds spend much of their time here.
        z = x * x
        w = z * z
        v = z * x
        r = 0.00833333333332249 + z * (-0.0001984126982985795 + z * 2.7557313707070068e-06)
        r += z * w * (-2.5050760253406863e-08 + z * 1.58969099521155e-10)
        s = x - (v * 0.16666666666666632 - z * (v * r))
        r = z * (0.0416666666666666 + z * (-0.001388888888887411 + z * 2.480158728947673e-05))
        r += w * w * (-2.7557314351390663e-07 + z * (2.087572321298175e-09 + z * -1.1359647557788195e-11))
        half = 0.5 * z
        w = 1.0 - half
        return s, w + (((1.0 - w) - half) + z * r)
    quarter, head, tail = _far_remainder(x)
    s, c = _near_sin(head, tail), _near_cos(head, tail)
    if quarter == 0:
        return s, c
    if quarter == 1:
        return c, -s
    if quarter == 2:
        return -s, -c
    return -c, s


def tan(x: float) -> float:
    """Return the tangent of x radians."""
    s, c = sincos(x)
    return s / c


def _arc_tangent(t: float) -> float:
    """Return atan t for t >= 0."""
    if t >= 7.378697629483821e19:
        return 1.5707963267948966
    if t < 0.4375:
        high, low, x = 0.0, 0.0, t
    elif t < 0.6875:
        high, low, x = 0.4636476090008061, 2.2698777452961687e-17, (2.0 * t - 1.0) / (2.0 + t)
    elif t < 1.1875:
        high, low, x = 0.7853981633974483, 3.061616997868383e-17, (t - 1.0) / (t + 1.0)
    elif t < 2.4375:
        high, low, x = 0.982793723247329, 1.3903311031230998e-17, (t - 1.5) / (1.0 + 1.5 * t)
    else:
        high, low, x = 1.5707963267948966, 6.123233995736766e-17, -1.0 / t
    z = x * x
    w = z * z
    odd = 0.049768779946159324 + w * 0.016285820115365782
    odd = 0.06661073137387531 + w * odd
    odd = 0.09090887133436507 + w * odd
    odd = 0.14285714272503466 + w * odd
    odd = z * (0.3333333333333293 + w * odd)
    even = -0.058335701337905735 + w * -0.036531572744216916
    even = -0.0769187620504483 + w * even
    even = -0.11111110405462356 + w * even
    even = w * (-0.19999999999876483 + w * even)
    if t < 0.4375:
        return x - x * (odd + even)
    return high - ((x * (odd + even) - low) - x)


def atan2(y: float, x: float) -> float:
    """Return the direction of the vector (x, y), radians in (-pi, pi].

    Exact on the axes. The zero vector has direction 0. Unlike with `math.atan2`, signed zeros make no difference.
    """
    if y == 0.0:
        return 0.0 if x >= 0.0 else _PI
    if x == 0.0:
        return 1.5707963267948966 if y > 0.0 else -1.5707963267948966
    angle = _arc_tangent(abs(y / x))
    if x < 0.0:
        angle = _PI - (angle - _PI_LOW)
    if y > 0.0:
        return angle
    # Just below the negative axis it rounds to -pi, which is not a heading.
    return -angle if angle != _PI else _PI


def atan(x: float) -> float:
    """Return the arc tangent of x, radians."""
    return _arc_tangent(x) if x >= 0.0 else -_arc_tangent(-x)


def asin(x: float) -> float:
    """Return the arc sine of x, radians in [-pi/2, pi/2]. `ValueError` beyond 1."""
    return atan2(x, sqrt((1.0 - x) * (1.0 + x)))


def acos(x: float) -> float:
    """Return the arc cosine of x, radians in [0, pi]. `ValueError` beyond 1."""
    return atan2(sqrt((1.0 - x) * (1.0 + x)), x)


def hypot(x: float, y: float) -> float:
    """Return the length of the vector (x, y). Below 1e-154 and above 1e154 the squares are out of range."""
    return sqrt(x * x + y * y)


def dist(p: Sequence[float], q: Sequence[float]) -> float:
    """Return the distance between two points of the plane. `ValueError` for other than two coordinates."""
    (px, py), (qx, qy) = p, q
    x, y = px - qx, py - qy
    return sqrt(x * x + y * y)


def log(x: float) -> float:
    """Return the natural logarithm of x. `ValueError` for 0 and below."""
    if not 0.0 < x < math.inf:
        return math.log(x)  # an error, or the value itself
    mantissa, exponent = frexp(x)
    # The mantissa is brought into [sqrt(2)/2, sqrt(2)), the exponent carries.
    if 2.0 * mantissa < _SQRT_2_SPLIT:
        mantissa *= 2.0
        exponent -= 1
    f = mantissa - 1.0
    if f == 0.0:
        return exponent * _LN2_HIGH + exponent * _LN2_LOW
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    even = w * (0.3999999999940942 + w * (0.22222198432149784 + w * 0.15313837699209373))
    odd = z * (0.6666666666666735 + w * (0.2857142874366239 + w * (0.1818357216161805 + w * 0.14798198605116586)))
    half = 0.5 * f * f
    return exponent * _LN2_HIGH - ((half - (s * (half + (odd + even)) + exponent * _LN2_LOW)) - f)


def exp(x: float) -> float:
    """Return e to the x. `OverflowError` above 709.78; 0 below -745.13."""
    if not -745.1332191019411 <= x <= 709.782712893384:
        return math.exp(x)  # an error, infinity, NaN or 0: none of them is rounded
    count = int(1.4426950408889634 * x + 0.5) if x >= 0.0 else -int(0.5 - 1.4426950408889634 * x)
    high = x - count * _LN2_HIGH
    low = count * _LN2_LOW
    r = high - low
    t = r * r
    c = 6.613756321437934e-05 + t * (-1.6533902205465252e-06 + t * 4.1381367970572385e-08)
    c = r - t * (0.16666666666666602 + t * (-0.0027777777777015593 + t * c))
    return ldexp(1.0 - ((low - (r * c) / (2.0 - c)) - high), count)


def power(base: float, exponent: float) -> float:
    """Return a base above 0 to an exponent."""
    return exp(exponent * log(base))
