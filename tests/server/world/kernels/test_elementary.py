"""The project's elementary functions against Python's `math`, which is within 1 ulp on any platform in use."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from intellwheels_server.world.kernels import elementary

# Ours is under 2 ulp and the C library's under 1, so they may differ by 3; 4 leaves a margin.
ULPS = 4
RNG = np.random.default_rng(20080917)


def angles() -> list[float]:
    small = RNG.uniform(-7.0, 7.0, 4000)
    wide = RNG.uniform(-1e6, 1e6, 4000)
    tiny = 10.0 ** RNG.uniform(-300.0, 0.0, 500)
    # Next to multiples of pi/2 nearly all bits cancel.
    near = np.arange(-3000, 3000) * (math.pi / 2)
    return [*small.tolist(), *wide.tolist(), *tiny.tolist(), *near.tolist(), *np.nextafter(near, np.inf).tolist()]


def worst(pairs: list[tuple[float, float]]) -> float:
    return max(abs(got - true) / math.ulp(true) for got, true in pairs)


@pytest.mark.parametrize(("ours", "theirs"), [(elementary.sin, math.sin), (elementary.cos, math.cos)])
def test_sine_and_cosine_are_within_ulps_up_to_a_million_radians(
    ours: Callable[[float], float], theirs: Callable[[float], float]
) -> None:
    assert worst([(ours(x), theirs(x)) for x in angles()]) <= ULPS


def test_sincos_is_sin_and_cos_to_the_bit() -> None:
    assert all(elementary.sincos(x) == (elementary.sin(x), elementary.cos(x)) for x in angles())


def test_sine_is_odd_and_cosine_even_to_the_bit() -> None:
    assert all(elementary.sin(-x) == -elementary.sin(x) and elementary.cos(-x) == elementary.cos(x) for x in angles())


def test_angles_out_of_range_give_nan_and_not_a_wrong_number() -> None:
    for x in (1.1e6, -1.1e6, math.inf, math.nan):
        assert math.isnan(elementary.sin(x))
        assert math.isnan(elementary.cos(x))
        assert math.isnan(elementary.wrap(x))


def test_zero_angle_is_exact() -> None:
    assert elementary.sin(0.0) == 0.0
    assert elementary.cos(0.0) == 1.0


def test_atan2_is_within_ulps() -> None:
    scales = ([1.0, 1.0], [1e-9, 1.0], [1.0, 1e-7])
    vectors = np.concatenate([RNG.uniform(-1.0, 1.0, (4000, 2)) * scale for scale in scales])
    assert worst([(elementary.atan2(y, x), math.atan2(y, x)) for y, x in vectors.tolist()]) <= ULPS


def test_atan2_is_exact_on_axes_and_never_minus_pi() -> None:
    assert elementary.atan2(0.0, 1.0) == 0.0
    assert elementary.atan2(1.0, 0.0) == math.pi / 2
    assert elementary.atan2(-1.0, 0.0) == -math.pi / 2
    assert elementary.atan2(0.0, -1.0) == math.pi
    assert elementary.atan2(-0.0, -1.0) == math.pi
    assert elementary.atan2(-1e-300, -1.0) == math.pi
    assert elementary.atan2(0.0, 0.0) == 0.0
    assert elementary.atan2(1.0, 1.0) == math.pi / 4


def test_log_is_within_ulps() -> None:
    values = [*RNG.uniform(0.0, 2.0, 4000).tolist(), *(10.0 ** RNG.uniform(-307, 308, 4000)).tolist(), 5e-324, 1e-310]
    assert worst([(elementary.log(x), math.log(x)) for x in values if x != 1.0]) <= ULPS


def test_log_at_the_edges_of_its_domain() -> None:
    assert elementary.log(1.0) == 0.0
    assert elementary.log(0.0) == -math.inf
    assert elementary.log(math.inf) == math.inf
    assert math.isnan(elementary.log(-1.0))
    assert math.isnan(elementary.log(math.nan))


def test_exp_is_within_ulps() -> None:
    values = [*RNG.uniform(-1.0, 1.0, 4000).tolist(), *RNG.uniform(-745.0, 709.7, 4000).tolist(), 709.782712893384]
    assert worst([(elementary.exp(x), math.exp(x)) for x in values]) <= ULPS


def test_exp_at_the_edges_of_its_domain() -> None:
    assert elementary.exp(0.0) == 1.0
    assert elementary.exp(-math.inf) == 0.0
    assert elementary.exp(-746.0) == 0.0
    assert elementary.exp(710.0) == math.inf
    assert math.isnan(elementary.exp(math.nan))


def test_wrapped_angle_is_the_same_direction_in_the_heading_interval() -> None:
    for x in angles():
        heading = elementary.wrap(x)
        assert -math.pi < heading <= math.pi
        # An ulp of the angle itself is lost when it is large, not more.
        assert abs(math.remainder(heading - x, 2 * math.pi)) <= max(4 * math.ulp(x), 1e-15)


def test_heading_in_its_interval_is_not_touched_by_wrap() -> None:
    for x in (0.0, 1.0, -3.141592653589793 + 4.5e-16, math.pi, 5e-324):
        assert elementary.wrap(x) == x


def test_minus_pi_wraps_to_pi() -> None:
    assert elementary.wrap(-math.pi) == math.pi
