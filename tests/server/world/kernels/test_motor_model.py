"""Motors and wheels, against the figures of the paper's equation (1) and of exact integration."""

import math
from pathlib import Path

import numpy as np
import pytest

import intellwheels_server.world
from intellwheels_server.world.kernels.arrays import TRAVEL, TURN, Floats
from intellwheels_server.world.kernels.geometry import arc
from intellwheels_server.world.kernels.motor_model import (
    LEFT,
    MOTOR_ACCELERATION,
    RIGHT,
    drive,
    lag,
    wheel_cycle,
    wheel_scales,
)
from tests.every_case import every_case

INF = math.inf
MODEL = Path(intellwheels_server.world.__file__).with_name("MODEL.md").read_text(encoding="utf-8")


def motor(
    track: float, kept: float = 0.0, settling: float = 0.0, rate: float = INF, *, top_speed: float = 1.0,
    turn_rate: float = INF, scales: tuple[float, float] = (1.0, 1.0),
) -> Floats:  # fmt: skip
    """Return the motor block of one body without a limit of acceleration."""
    return np.array([track, top_speed, kept, settling, INF, turn_rate, *scales, rate]).reshape(-1, 1)


def roll(
    motors: Floats, wheels: Floats, powers: tuple[float, float], period: float, twist: Floats, noise: float = 0.0,
    tick: int = 0,
) -> None:  # fmt: skip
    """Drive one body for a tick; `wheels` and `twist` are written."""
    flaws, keys = np.array([[noise], [0.0]]), np.array([[1], [2]], dtype=np.int64)
    drive(motors, flaws, keys, wheels, np.array(powers).reshape(2, 1), tick, period, twist, wheels)


def driven(
    a: float, period: float, powers: list[tuple[float, float, float]], track: float = 0.572
) -> tuple[float, float, float]:
    """Return the pose after powers (left, right, seconds) from rest, one after another, at 1 m/s top speed."""
    motors = motor(track, *lag(a, period))
    wheels, twist = np.zeros((2, 1)), np.zeros((2, 1))
    pose = (0.0, 0.0, 0.0)
    for left, right, seconds in powers:
        for _ in range(round(seconds / period)):
            roll(motors, wheels, (left, right), period, twist)
            pose = arc(*pose, twist[TRAVEL, 0], twist[TURN, 0])[:3]
    return pose


@pytest.mark.parametrize("period", [0.1, 0.05, 0.02, 0.01])
def test_way_of_the_first_second_does_not_depend_on_the_cycle(period: float) -> None:
    # MODEL.md, Motion: a = 0.9, full power, 1 m/s.
    x, y, heading = driven(0.9, period, [(1.0, 1.0, 1.0)])
    assert x == pytest.approx(0.583134469338476, abs=1e-14)
    assert (y, heading) == (0.0, 0.0)


@pytest.mark.parametrize(("period", "total"), [(0.05, 0.6047), (0.1, 0.6255)])
def test_sum_of_the_paper_depends_on_the_cycle_as_the_page_says(period: float, total: float) -> None:
    kept, output, summed = 0.9 ** (period / 0.05), 0.0, 0.0
    for _ in range(round(1.0 / period)):
        output = 1.0 - kept + kept * output
        summed += output * period
    assert summed == pytest.approx(total, abs=5e-5)
    assert f"{total} m at {round(1000.0 * period)} ms" in MODEL


def test_way_is_the_closed_integral() -> None:
    tau = -0.05 / math.log(0.9)
    assert driven(0.9, 0.05, [(1.0, 1.0, 1.0)])[0] == pytest.approx(1.0 - tau * (1.0 - math.exp(-1.0 / tau)), abs=1e-14)


def test_larger_wheel_rolls_farther_for_the_same_power_and_its_mean_stays() -> None:
    left, right = wheel_scales(1.01, 1.0)
    assert (right / left, 0.5 * (left + right)) == pytest.approx((1.01, 1.0), abs=1e-15)
    assert wheel_scales(1.0, 1.0) == (1.0, 1.0)
    motors = motor(0.5, scales=(left, right))
    wheels, twist = np.zeros((2, 1)), np.zeros((2, 1))
    roll(motors, wheels, (1.0, 1.0), 0.05, twist)
    assert wheels[:, 0].tolist() == [left, right]
    assert twist[TRAVEL, 0] == pytest.approx(0.05, abs=1e-15)
    assert twist[TURN, 0] == pytest.approx((right - left) * 0.05 / 0.5, abs=1e-15)


@pytest.mark.parametrize("a", [0.0, 0.3, 0.5, 0.9, 0.99])
def test_reference_cycle_is_equation_one_to_the_bit(a: float) -> None:
    figures = lag(a, 0.05)
    assert figures[0] == a
    for speed, wanted in ((0.0, 1.0), (0.3, -0.7), (-0.11, 0.95)):
        assert wheel_cycle(speed, wanted, *figures, INF, 1.0, 0.05)[0] == (1.0 - a) * wanted + a * speed


@pytest.mark.parametrize("a", [0.3, 0.5, 0.9, 0.99])
def test_two_half_cycles_are_one_whole(a: float) -> None:
    whole = wheel_cycle(0.3, -0.7, *lag(a, 0.05), INF, 1.0, 0.05)
    speed, first = wheel_cycle(0.3, -0.7, *lag(a, 0.025), INF, 1.0, 0.025)
    speed, second = wheel_cycle(speed, -0.7, *lag(a, 0.025), INF, 1.0, 0.025)
    assert speed == pytest.approx(whole[0], abs=4 * math.ulp(1.0))
    assert first + second == pytest.approx(whole[1], abs=4 * math.ulp(1.0))


def test_without_inertia_the_wheel_obeys_at_once() -> None:
    assert lag(0.0, 0.02) == (0.0, 0.0, INF)
    assert wheel_cycle(-1.0, 0.5, 0.0, 0.0, INF, INF, 1.0, 0.02) == (0.5, 0.01)


def test_error_of_a_turning_transient_falls_with_the_square_of_the_cycle() -> None:
    # MODEL.md, Motion: from (1, 1) to (-0.5, 0.5) for 2 s, track 0.572: 1.28 mm at 0.1 s, 0.32 at 0.05.
    steps = [(1.0, 1.0, 3.0), (-0.5, 0.5, 2.0)]

    def end(period: float) -> tuple[float, float]:
        return driven(0.9, period, steps)[:2]

    true = end(0.0005)
    coarse, fine = math.dist(end(0.1), true), math.dist(end(0.05), true)
    assert coarse / fine == pytest.approx(4.0, abs=0.4)
    assert coarse == pytest.approx(1.28e-3, abs=0.02e-3)
    assert fine == pytest.approx(0.32e-3, abs=0.01e-3)


@pytest.mark.parametrize("cuts", [1, 2, 10, 1000])
def test_quarter_turn_does_not_depend_on_how_it_is_cut(cuts: int) -> None:
    pose = (0.0, 0.0, 0.0)
    for _ in range(cuts):
        pose = arc(*pose, math.pi / 2 / cuts, math.pi / 2 / cuts)[:3]
    assert pose == pytest.approx((1.0, 1.0, math.pi / 2), abs=1e-13)


def test_ten_metres_of_a_curve_end_where_the_circle_does() -> None:
    # Euler integration with the old heading is 4 cm off here (MODEL.md, Motion).
    x, y, heading = driven(0.0, 0.05, [(0.9, 1.0, 10.0 / 0.95)])
    rate = 0.1 / 0.572
    seconds = round(10.0 / 0.95 / 0.05) * 0.05
    radius = 0.95 / rate
    assert heading == pytest.approx(rate * seconds, abs=1e-12)
    assert (x, y) == pytest.approx(
        (radius * math.sin(rate * seconds), radius * (1.0 - math.cos(rate * seconds))), abs=1e-11
    )


@pytest.mark.parametrize("turn", [1e-9, 9.99e-7, 1.01e-6, 1e-5])
def test_series_of_small_turns_meets_the_exact_arc(turn: float) -> None:
    x, y, heading, c, s = arc(0.0, 0.0, 0.0, 2.0, turn)
    assert (x, y) == pytest.approx((2.0, turn), rel=1e-10)
    assert (heading, c, s) == (turn, math.cos(turn), math.sin(turn))


def test_standing_still_leaves_every_bit() -> None:
    assert arc(0.1, -0.7, 3.1, 0.0, 0.0)[:3] == (0.1, -0.7, 3.1)


def test_acceleration_is_limited_after_the_lag() -> None:
    speed, travel = wheel_cycle(0.0, 1.0, *lag(0.5, 0.05), 2.0, 1.0, 0.05)
    assert speed == pytest.approx(0.1)
    assert travel == pytest.approx(0.0025)
    # Below the limit the lag alone counts.
    assert wheel_cycle(0.0, 1.0, *lag(0.5, 0.05), 20.0, 1.0, 0.05)[0] == 0.5


@every_case("a", [0.0, 0.5, 0.95])
@every_case("limit", [0.3, 1.0, 2.0])
def test_limited_wheel_meets_the_closed_solution_whatever_the_cycle(a: float, limit: float) -> None:
    tau = -0.05 / math.log(a) if a > 0.0 else 0.0
    # Even until the lag asks for less than the limit, then exponential: from 0.2 to -0.9 m/s in 6 s.
    wanted, seconds = -0.9, 6.0
    even = max(0.0, (1.1 - limit * tau) / limit)
    then = 0.2 - limit * even
    decay = math.exp(-(seconds - even) / tau) if tau > 0.0 else 0.0
    end = wanted + (then - wanted) * decay
    way = 0.5 * (0.2 + then) * even + wanted * (seconds - even) + (then - wanted) * tau * (1.0 - decay)
    for period in (0.01, 0.02, 0.05, 0.1, 0.2, 1.0):
        speed, travel = 0.2, 0.0
        for _ in range(round(seconds / period)):
            speed, rolled = wheel_cycle(speed, wanted, *lag(a, period), limit, 1.0, period)
            travel += rolled
        assert (speed, travel) == pytest.approx((end, way), abs=1e-12)


def test_top_speed_is_kept_even_with_a_motor_that_gives_too_much() -> None:
    speed, travel = wheel_cycle(1.0, 1.05, 0.0, 0.0, INF, INF, 1.0, 0.05)
    assert (speed, travel) == (1.0, 0.05)


def limited(rate: float) -> tuple[Floats, Floats]:
    twist, wheels = np.zeros((2, 1)), np.zeros((2, 1))
    roll(motor(0.5, turn_rate=rate), wheels, (0.0, 1.0), 0.05, twist)
    return twist, wheels


def test_turn_limit_scales_the_difference_and_leaves_the_mean() -> None:
    twist, wheels = limited(1.0)
    assert twist[:, 0].tolist() == [0.025, 0.05]
    assert wheels[:, 0].tolist() == [0.25, 0.75]
    assert limited(INF)[0][:, 0].tolist() == [0.025, 0.1]


def test_body_without_motors_stands_still() -> None:
    twist, wheels = np.ones((2, 1)), np.ones((2, 1))
    roll(motor(0.5, top_speed=0.0), wheels, (1.0, 1.0), 0.05, twist)
    assert not twist.any()
    assert not wheels.any()


def test_right_wheel_faster_turns_left() -> None:
    _, y, heading = driven(0.5, 0.05, [(0.5, 1.0, 0.5)])
    assert y > 0.0
    assert heading > 0.0
    assert (LEFT, RIGHT) == (0, 1)


def test_wheel_that_hardly_obeys_at_all_hardly_moves_whatever_the_cycle() -> None:
    for period in (0.001, 0.05, 1.0):
        for a in (1.0 - 2.0**-53, 1.0 - 1e-12):
            speed, travel = wheel_cycle(0.0, 1.0, *lag(a, period), INF, 1.0, period)
            assert 0.0 <= travel <= 1e-9
            assert 0.0 <= speed <= 1e-9


def test_spin_of_a_chair_is_not_cut_short_by_a_long_cycle() -> None:
    _, _, heading = driven(0.0, 1.0, [(-1.0, 1.0, 1.0)])
    assert heading == pytest.approx(2.0 / 0.572 - 2.0 * math.pi)


@pytest.mark.parametrize(("a", "limit"), [(0.0, INF), (0.9, INF), (0.0, 0.5), (0.6, 1.0)])
def test_noisy_wheels_are_where_they_are_whatever_the_cycle(a: float, limit: float) -> None:
    found = []
    for period in (0.01, 0.02, 0.05, 0.1, 0.2):
        motors = motor(0.5, *lag(a, period))
        motors[MOTOR_ACCELERATION] = limit
        wheels, twist, rolled = np.zeros((2, 1)), np.zeros((2, 1)), np.zeros(2)
        for tick in range(round(2.0 / period)):
            roll(motors, wheels, (0.6, 0.5), period, twist, 0.05, tick)
            rolled += twist[:, 0]
        found.append([*wheels[:, 0], *rolled])
    assert found[0] != pytest.approx([0.6, 0.5, 1.1, -0.4], abs=1e-3)
    for other in found[1:]:
        assert other == pytest.approx(found[0], abs=1e-12)
