"""Sine, cosine, arc tangent, logarithm and exponential that give the same bits everywhere.

Those of the C library differ in the last bit between processors and versions, so a run would not
repeat on another machine. These use only + - * /, which IEEE 754 rounds correctly, and
integer operations on the bits of a float; numba does not fuse or reorder them. Errors stay under
2 ulp on the ranges stated.

Source:
    Polynomials, thresholds and split constants of FDLIBM (`k_sin.c`, `k_cos.c`, `e_rem_pio2.c`, `s_atan.c`,
    `e_atan2.c`, `e_log.c`, `e_exp.c`), Copyright (C) 1993 by Sun Microsystems, Inc., freely granted provided
    that this notice is preserved.
"""

import numpy as np
from numba import njit

PI = 3.141592653589793
TWO_PI = 6.283185307179586

# pi minus the float PI, for sums that must be correct in their last bit.
_PI_LOW = 1.2246467991473532e-16

# Beyond it the product of the quarter turns and the first part of pi/2 is no longer exact.
_LARGEST_ANGLE = 1e6

_TWO_OVER_PI = 0.6366197723675814
# pi/2 in pieces of 33 bits (head) and what is left (tail).
_HALF_PI_1, _HALF_PI_1_TAIL = 1.5707963267341256, 6.077100506506192e-11
_HALF_PI_2, _HALF_PI_2_TAIL = 6.077100506303966e-11, 2.0222662487959506e-21
_HALF_PI_3, _HALF_PI_3_TAIL = 2.0222662487111665e-21, 8.4784276603689e-32

_LN2_HIGH = 0.6931471803691238
_LN2_LOW = 1.9082149292705877e-10


@njit(cache=True, error_model="numpy", inline="never")
def _far_remainder(x: float) -> tuple[int, float, float]:
    """Return the quarter turns in x and the rest, in [-pi/4, pi/4], as head and tail."""
    turns = int(x * _TWO_OVER_PI + 0.5) if x >= 0.0 else -int(0.5 - x * _TWO_OVER_PI)
    count = float(turns)
    rest = x - count * _HALF_PI_1
    lost = count * _HALF_PI_1_TAIL
    head = rest - lost
    if abs(head) < abs(x) * 1.52587890625e-05:
        # More than 16 bits cancelled: subtract 33 more bits of pi/2.
        before = rest
        lost = count * _HALF_PI_2
        rest = before - lost
        lost = count * _HALF_PI_2_TAIL - ((before - rest) - lost)
        head = rest - lost
        if abs(head) < abs(x) * 1.7763568394002505e-15:
            # More than 49 bits.
            before = rest
            lost = count * _HALF_PI_3
            rest = before - lost
            lost = count * _HALF_PI_3_TAIL - ((before - rest) - lost)
            head = rest - lost
    return turns, head, (rest - head) - lost


@njit(cache=True, error_model="numpy")
def _near_sin(x: float, tail: float) -> float:
    """Return sin(x + tail) for |x| <= pi/4."""
    z = x * x
    w = z * z
    r = 0.00833333333332249 + z * (-0.0001984126982985795 + z * 2.7557313707070068e-06)
    r += z * w * (-2.5050760253406863e-08 + z * 1.58969099521155e-10)
    v = z * x
    return x - ((z * (0.5 * tail - v * r) - tail) - v * -0.16666666666666632)


@njit(cache=True, error_model="numpy")
def _near_cos(x: float, tail: float) -> float:
    """Return cos(x + tail) for |x| <= pi/4."""
    z = x * x
    w = z * z
    r = z * (0.0416666666666666 + z * (-0.001388888888887411 + z * 2.480158728947673e-05))
    r += w * w * (-2.7557314351390663e-07 + z * (2.087572321298175e-09 + z * -1.1359647557788195e-11))
    half = 0.5 * z
    w = 1.0 - half
    return w + (((1.0 - w) - half) + (z * r - x * tail))


@njit(cache=True, error_model="numpy")
def sincos(x: float) -> tuple[float, float]:
    """Return (sin x, cos x).

    Args:
        x: Angle in radians, |x| <= 1e6. Beyond, and for NaN, both are NaN.
    """
    if abs(x) <= 0.7853981633974483:
        return _near_sin(x, 0.0), _near_cos(x, 0.0)
    if not abs(x) <= _LARGEST_ANGLE:
        return np.nan, np.nan
    turns, head, tail = _far_remainder(x)
    s = _near_sin(head, tail)
    c = _near_cos(head, tail)
    quarter = turns & 3
    if quarter == 0:
        return s, c
    if quarter == 1:
        return c, -s
    if quarter == 2:
        return -s, -c
    return -c, s


@njit(cache=True, error_model="numpy")
def sin(x: float) -> float:
    """Return the sine of x radians, |x| <= 1e6; NaN beyond."""
    return sincos(x)[0]


@njit(cache=True, error_model="numpy")
def cos(x: float) -> float:
    """Return the cosine of x radians, |x| <= 1e6; NaN beyond."""
    return sincos(x)[1]


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def atan2(y: float, x: float) -> float:
    """Return the direction of the vector (x, y), radians in (-pi, pi].

    Exact on the axes: 0, PI/2, PI, -PI/2. The zero vector has direction 0. Unlike C's, signed
    zeros make no difference: (-1, -0.0) points to +PI, since headings never are -PI.

    Args:
        y: Ordinate, finite.
        x: Abscissa, finite; the quotient may overflow or underflow.
    """
    if np.isnan(x) or np.isnan(y):
        return np.nan
    if y == 0.0:
        return 0.0 if x >= 0.0 else PI
    if x == 0.0:
        return 1.5707963267948966 if y > 0.0 else -1.5707963267948966
    angle = _arc_tangent(abs(y / x))
    if x < 0.0:
        angle = PI - (angle - _PI_LOW)
    if y > 0.0:
        return angle
    # Just below the negative axis it rounds to -PI, which is not a heading.
    return -angle if angle < PI else PI


@njit(cache=True, error_model="numpy")
def log(x: float) -> float:
    """Return the natural logarithm of x: -inf at 0, NaN below."""
    if not x > 0.0:
        return -np.inf if x == 0.0 else np.nan
    if x == np.inf:
        return np.inf
    exponent = 0
    if x < 2.2250738585072014e-308:
        exponent = -54
        x *= 18014398509481984.0
    bits = int(np.float64(x).view(np.int64))
    exponent += (bits >> 52) - 1023
    fraction = bits & 0xFFFFFFFFFFFFF
    # The mantissa is brought into [sqrt(2)/2, sqrt(2)), the exponent carries.
    carry = ((fraction + 0x95F6400000000) >> 52) & 1
    exponent += carry
    f = np.int64(fraction | ((1023 - carry) << 52)).view(np.float64) - 1.0
    k = float(exponent)
    if f == 0.0:
        return k * _LN2_HIGH + k * _LN2_LOW
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    even = w * (0.3999999999940942 + w * (0.22222198432149784 + w * 0.15313837699209373))
    odd = z * (0.6666666666666735 + w * (0.2857142874366239 + w * (0.1818357216161805 + w * 0.14798198605116586)))
    half = 0.5 * f * f
    return k * _LN2_HIGH - ((half - (s * (half + (odd + even)) + k * _LN2_LOW)) - f)


@njit(cache=True, error_model="numpy")
def exp(x: float) -> float:
    """Return e to the x: inf above 709.78, 0 below -745.13."""
    if not x <= 709.782712893384:
        return np.inf if x > 0.0 else np.nan
    if x < -745.1332191019411:
        return 0.0
    count = int(1.4426950408889634 * x + 0.5) if x >= 0.0 else -int(0.5 - 1.4426950408889634 * x)
    high = x - float(count) * _LN2_HIGH
    low = float(count) * _LN2_LOW
    r = high - low
    t = r * r
    c = 6.613756321437934e-05 + t * (-1.6533902205465252e-06 + t * 4.1381367970572385e-08)
    c = r - t * (0.16666666666666602 + t * (-0.0027777777777015593 + t * c))
    y = 1.0 - ((low - (r * c) / (2.0 - c)) - high)
    if count > 1023:
        return y * 2.0 * np.int64((count + 1022) << 52).view(np.float64)
    if count >= -1021:
        return y * np.int64((count + 1023) << 52).view(np.float64)
    # The result may be subnormal: scale in two steps, the second rounds once.
    return y * np.int64((count + 2023) << 52).view(np.float64) * 9.332636185032189e-302


@njit(cache=True, error_model="numpy")
def wrap(angle: float) -> float:
    """Return the same direction as a heading in (-pi, pi]. A heading in this range is returned unchanged.

    Args:
        angle: Radians, |angle| <= 1e6; NaN beyond.
    """
    if -PI < angle <= PI:
        return angle
    if angle == -PI:
        return PI
    if not abs(angle) <= _LARGEST_ANGLE:
        return np.nan
    turns = int(angle / TWO_PI + 0.5) if angle >= 0.0 else -int(0.5 - angle / TWO_PI)
    count = 4.0 * float(turns)
    rest = (angle - count * _HALF_PI_1) - count * _HALF_PI_1_TAIL
    # The count was rounded from a quotient that was itself rounded.
    if rest > PI:
        rest -= TWO_PI
    elif rest <= -PI:
        rest += TWO_PI
    return rest if -PI < rest <= PI else PI
