"""Motors and wheels: from powers to the twist of a tick.

v is the speed of a wheel, u the commanded one (power x TopSpeed), T the cycle, a the AccelerationCurve at the reference
cycle T0 = 50 ms:

    v' = (1 - k) u + k v,  k = e^(-T/tau) = a^(T/T0)          equation (1) of the paper, at T = T0 to the bit
    travel = u T + (v - u) tau (1 - k)                         the integral of v over the cycle

Limits act in this order: lag, acceleration, top speed, turn rate. A wheel whose lag asks for more than the acceleration
changes its speed evenly, until the lag asks for less:

    dv/dt = (u - v) / tau, within +-AccelerationLimit          solved exactly within the cycle, so for any T

`motor_noise` varies the power. A cycle in which it changes is integrated piece by piece.
"""

import math

import numpy as np
from numba import njit

from intellwheels_schemas.messages import Robot
from intellwheels_server.world.kernels.arrays import TRAVEL, TURN, Floats, Ints
from intellwheels_server.world.kernels.elementary import exp, log
from intellwheels_server.world.kernels.motor_noise import HOLD, MOTOR_NOISE, interval_of, noise_factor

# The cycle for which the paper gives AccelerationCurve, s.
REFERENCE_CYCLE = 0.05

# Rows of a motor block, float64[MOTOR_ROWS, n].
MOTOR_TRACK = 0
"""True distance between the wheels, m."""
MOTOR_TOP_SPEED = 1
"""Speed of a nominal wheel at power 1, m/s."""
MOTOR_KEPT = 2
"""k: share of the last speed that is kept in a cycle."""
MOTOR_SETTLING = 3
"""tau (1 - k), s."""
MOTOR_ACCELERATION = 4
"""Limit of a wheel's acceleration, m/s2; inf for none."""
MOTOR_TURN_RATE = 5
"""Limit of the turn rate, rad/s; inf for none."""
MOTOR_LEFT_SCALE = 6
"""True left wheel over the nominal one. A motor turns a larger wheel at the same rate, so it moves farther."""
MOTOR_RIGHT_SCALE = 7
"""True right wheel over the nominal one."""
MOTOR_RATE = 8
"""1/tau, 1/s; inf without lag."""
MOTOR_ROWS = 9

# Rows of a wheels or power block, float64[2, n].
LEFT, RIGHT = 0, 1

# Limit of the turn rate, rad/s. With a track of a micrometre the angle would leave every range.
_MOST_TURN_RATE = 60.0
# For a cycle below this share of tau, 1 - k has lost five digits. A series then has an error below 1e-16.
_SHORT = 1e-5


def motor_figures(robot: Robot, period: float) -> tuple[float, ...]:
    """Return the column of the motor block for a robot, rows `MOTOR_TRACK` to `MOTOR_RATE`.

    Args:
        robot: The robot.
        period: T, s, > 0.
    """
    kept, settling, rate = lag(robot.acceleration_curve, period)
    return (
        robot.track * robot.track_ratio,
        robot.top_speed,
        kept,
        settling,
        math.inf if robot.acceleration_limit is None else robot.acceleration_limit,
        math.inf if robot.turn_limit is None else robot.turn_limit,
        *wheel_scales(robot.wheel_ratio, robot.wheel_scale),
        rate,
    )


def most_motion(robot: Robot, period: float, radius: float) -> float:
    """Return how far a point of a robot moves in a tick at most, m.

    Args:
        robot: The robot.
        period: T, s, > 0.
        radius: Distance of its farthest corner from its centre of movement, m.
    """
    fastest = robot.top_speed * max(wheel_scales(robot.wheel_ratio, robot.wheel_scale))
    rate = min(
        _MOST_TURN_RATE,
        math.inf if robot.turn_limit is None else robot.turn_limit,
        2.0 * fastest / (robot.track * robot.track_ratio),
    )
    return (fastest + rate * radius) * period


def wheel_scales(ratio: float, scale: float) -> tuple[float, float]:
    """Return the true left and right wheel over the nominal one.

    Args:
        ratio: E_d of UMBmark, the right wheel over the left one at the same mean.
        scale: Their mean over the nominal wheel.
    """
    left = 2.0 / (1.0 + ratio)
    return scale * left, scale * (ratio * left)


@njit(cache=True, error_model="numpy")
def lag(acceleration_curve: float, period: float) -> tuple[float, float, float]:
    """Return the share of its speed a wheel keeps in a cycle, tau times the rest, s, and 1/tau, 1/s.

    Args:
        acceleration_curve: a, the share kept in 50 ms, in [0, 1); 0 means no lag.
        period: T, s, > 0.

    Source:
        Equation (1) of the IntellWheels simulator paper, with a = e^(-T0/tau).
    """
    if acceleration_curve <= 0.0:
        return 0.0, 0.0, np.inf
    rate = -log(acceleration_curve) / REFERENCE_CYCLE
    if period == REFERENCE_CYCLE:
        return acceleration_curve, _settling(acceleration_curve, rate, period), rate
    kept, settling = lag_over(rate, period)
    return kept, settling, rate


@njit(cache=True, error_model="numpy")
def lag_over(rate: float, seconds: float) -> tuple[float, float]:
    """Return the share of its speed a wheel keeps in a time, and tau times the rest, s.

    Args:
        rate: 1/tau, 1/s; inf without lag.
        seconds: The time, > 0.
    """
    kept = exp(-rate * seconds)
    return kept, _settling(kept, rate, seconds)


@njit(cache=True, error_model="numpy")
def _settling(kept: float, rate: float, seconds: float) -> float:
    share = rate * seconds
    if share < _SHORT:
        return seconds * (1.0 - share * (0.5 - share / 6.0))
    return (1.0 - kept) / rate


@njit(cache=True, error_model="numpy")
def wheel_cycle(
    speed: float, wanted: float, kept: float, settling: float, rate: float, acceleration: float, top_speed: float,
    period: float,
) -> tuple[float, float]:  # fmt: skip
    """Return the speed of a wheel after a cycle, m/s, and how far it rolled, m.

    Args:
        speed: v at the start, m/s.
        wanted: u, m/s.
        kept: Share of the speed kept, k.
        settling: tau (1 - k), s.
        rate: 1/tau, 1/s; inf without lag.
        acceleration: Limit, m/s2; inf for none.
        top_speed: Limit, m/s.
        period: T, s.
    """
    # The lag asks for (wanted - speed) / tau, so beyond this difference the acceleration is at its limit.
    over = abs(wanted - speed) - acceleration / rate if acceleration < np.inf else 0.0
    if over <= 0.0:
        new = (1.0 - kept) * wanted + kept * speed
        travel = wanted * period + (speed - wanted) * settling
    else:
        even = min(over / acceleration, period)
        new = speed + acceleration * even if wanted > speed else speed - acceleration * even
        travel = 0.5 * (speed + new) * even
        rest = period - even
        if rest > 0.0:
            kept, settling = lag_over(rate, rest)
            travel += wanted * rest + (new - wanted) * settling
            new = (1.0 - kept) * wanted + kept * new
    new = min(max(new, -top_speed), top_speed)
    travel = min(max(travel, -top_speed * period), top_speed * period)
    return new, travel


@njit(cache=True, error_model="numpy")
def _roll(
    motors: Floats, i: int, left: float, right: float, power_left: float, power_right: float, kept: float,
    settling: float, seconds: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Return the wheel speeds of a body after a time of constant power, m/s, and its travel, m, and turn, rad."""
    top, lag_rate, acceleration = motors[MOTOR_TOP_SPEED, i], motors[MOTOR_RATE, i], motors[MOTOR_ACCELERATION, i]
    most_left, most_right = top * motors[MOTOR_LEFT_SCALE, i], top * motors[MOTOR_RIGHT_SCALE, i]
    left, rolled_left = wheel_cycle(
        left, power_left * most_left, kept, settling, lag_rate, acceleration, most_left, seconds
    )
    right, rolled_right = wheel_cycle(
        right, power_right * most_right, kept, settling, lag_rate, acceleration, most_right, seconds
    )
    track = motors[MOTOR_TRACK, i]
    travel = 0.5 * (rolled_left + rolled_right)
    turn = (rolled_right - rolled_left) / track
    rate = min(motors[MOTOR_TURN_RATE, i], _MOST_TURN_RATE)
    most = rate * seconds
    turn = min(max(turn, -most), most)
    if abs(right - left) > rate * track:
        # A turn limit scales the difference of the wheels and leaves their mean.
        mean = 0.5 * (left + right)
        half = 0.5 * rate * track if right > left else -0.5 * rate * track
        left, right = mean - half, mean + half
    return left, right, travel, turn


@njit(cache=True, error_model="numpy")
def drive_one(
    motors: Floats, flaws: Floats, keys: Ints, i: int, left: float, right: float, power_left: float,
    power_right: float, tick: int, period: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Return the wheel speeds of a body after a tick, m/s, and its travel, m, and turn, rad, if nothing is in the way.

    Args:
        motors: float64[MOTOR_ROWS, n], rows `MOTOR_TRACK` to `MOTOR_RATE`.
        flaws: float64[FLAW_ROWS, n].
        keys: int64[2, n], bits of the keys of the motors' noise.
        i: The body. It has motors.
        left: Speed of the left wheel at the start, m/s.
        right: Speed of the right wheel at the start, m/s.
        power_left: Share of full power in force.
        power_right: Share of full power in force.
        tick: The tick that the step starts from.
        period: T, s.
    """
    kept, settling = motors[MOTOR_KEPT, i], motors[MOTOR_SETTLING, i]
    if flaws[MOTOR_NOISE, i] <= 0.0:
        return _roll(motors, i, left, right, power_left, power_right, kept, settling, period)
    travel = turn = 0.0
    start, end = interval_of(tick, period), interval_of(tick + 1, period)
    whole = end <= np.floor(start) + 1.0
    while start < end:
        interval = int(start)
        stop = min(interval + 1.0, end)
        seconds = period
        if not whole:
            seconds = (stop - start) * HOLD
            kept, settling = lag_over(motors[MOTOR_RATE, i], seconds)
        left, right, rolled, turned = _roll(
            motors, i, left, right, power_left * noise_factor(flaws, keys, i, interval, LEFT),
            power_right * noise_factor(flaws, keys, i, interval, RIGHT), kept, settling, seconds,
        )  # fmt: skip
        if whole:
            return left, right, rolled, turned
        travel += rolled
        turn += turned
        start = stop
    return left, right, travel, turn


@njit(cache=True, error_model="numpy")
def drive(
    motors: Floats, flaws: Floats, keys: Ints, wheels: Floats, power: Floats, tick: int, period: float, twist: Floats,
    new_wheels: Floats,
) -> None:  # fmt: skip
    """Fill in the twist of the tick and the wheel speeds after it, for all bodies.

    Args:
        motors: float64[MOTOR_ROWS, n], rows `MOTOR_TRACK` to `MOTOR_RATE`.
        flaws: float64[FLAW_ROWS, n].
        keys: int64[2, n], bits of the keys of the motors' noise.
        wheels: float64[2, n], wheel speeds at the start, m/s.
        power: float64[2, n], shares of full power in force.
        tick: The tick that the step starts from.
        period: T, s.
        twist: float64[2, n], out: travel along the arc, m, and turn, rad.
        new_wheels: float64[2, n], out, m/s, as if nothing is in the way. May be `wheels` itself.
    """
    for i in range(motors.shape[1]):
        if motors[MOTOR_TOP_SPEED, i] <= 0.0:
            twist[TRAVEL, i] = 0.0
            twist[TURN, i] = 0.0
            new_wheels[LEFT, i] = 0.0
            new_wheels[RIGHT, i] = 0.0
            continue
        left, right, travel, turn = drive_one(
            motors, flaws, keys, i, wheels[LEFT, i], wheels[RIGHT, i], power[LEFT, i], power[RIGHT, i], tick, period
        )
        twist[TRAVEL, i] = travel
        twist[TURN, i] = turn
        new_wheels[LEFT, i] = left
        new_wheels[RIGHT, i] = right
