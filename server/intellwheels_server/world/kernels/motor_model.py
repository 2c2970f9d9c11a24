"""Motors and wheels: from powers to the twist of a tick.

v is the speed of a wheel, u the commanded one (power x TopSpeed), T the cycle, a the AccelerationCurve at the reference
cycle T0 = 50 ms:

    v' = (1 - k) u + k v,  k = e^(-T/tau) = a^(T/T0)          equation (1) of the paper, at T = T0 to the bit
    travel = u T + (v - u) tau (1 - k)                         the integral of v over the cycle

Limits act in this order: lag, acceleration, top speed, turn rate.
"""

import math

from numba import njit

from intellwheels_schemas.messages import Robot
from intellwheels_server.world.kernels.arrays import TRAVEL, TURN, Floats
from intellwheels_server.world.kernels.elementary import exp, log

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
MOTOR_ROWS = 8

# Rows of a wheels or power block, float64[2, n].
LEFT, RIGHT = 0, 1

# Limit of the turn rate, rad/s. With a track of a micrometre the angle would leave every range.
_MOST_TURN_RATE = 60.0
# For a cycle below this share of tau, 1 - k has lost five digits. A series then has an error below 1e-16.
_SHORT = 1e-5


def motor_figures(robot: Robot, period: float) -> tuple[float, ...]:
    """Return the column of the motor block for a robot, rows `MOTOR_TRACK` to `MOTOR_RIGHT_SCALE`.

    Args:
        robot: The robot.
        period: T, s, > 0.
    """
    kept, settling = lag(robot.acceleration_curve, period)
    return (
        robot.track * robot.track_ratio,
        robot.top_speed,
        kept,
        settling,
        math.inf if robot.acceleration_limit is None else robot.acceleration_limit,
        math.inf if robot.turn_limit is None else robot.turn_limit,
        *wheel_scales(robot.wheel_ratio, robot.wheel_scale),
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
def lag(acceleration_curve: float, period: float) -> tuple[float, float]:
    """Return the share of its speed a wheel keeps in a cycle, and tau times the rest, s.

    Args:
        acceleration_curve: a, the share kept in 50 ms, in [0, 1); 0 means no lag.
        period: T, s, > 0.

    Source:
        Equation (1) of the IntellWheels simulator paper, with a = e^(-T0/tau).
    """
    if acceleration_curve <= 0.0:
        return 0.0, 0.0
    rate = -log(acceleration_curve) / REFERENCE_CYCLE
    kept = acceleration_curve if period == REFERENCE_CYCLE else exp(-rate * period)
    share = rate * period
    if share < _SHORT:
        return kept, period * (1.0 - share * (0.5 - share / 6.0))
    return kept, (1.0 - kept) / rate


@njit(cache=True, error_model="numpy")
def wheel_cycle(
    speed: float, wanted: float, kept: float, settling: float, acceleration: float, top_speed: float, period: float
) -> tuple[float, float]:
    """Return the speed of a wheel after a cycle, m/s, and how far it rolled, m.

    Args:
        speed: v at the start, m/s.
        wanted: u, m/s.
        kept: Share of the speed kept, k.
        settling: tau (1 - k), s.
        acceleration: Limit, m/s2; the speed then changes evenly, and the travel is that of the mean.
        top_speed: Limit, m/s.
        period: T, s.
    """
    new = (1.0 - kept) * wanted + kept * speed
    travel = wanted * period + (speed - wanted) * settling
    most = acceleration * period
    if new > speed + most:
        new = speed + most
        travel = 0.5 * (speed + new) * period
    elif new < speed - most:
        new = speed - most
        travel = 0.5 * (speed + new) * period
    new = min(max(new, -top_speed), top_speed)
    travel = min(max(travel, -top_speed * period), top_speed * period)
    return new, travel


@njit(cache=True, error_model="numpy")
def drive(motors: Floats, wheels: Floats, power: Floats, period: float, twist: Floats, new_wheels: Floats) -> None:
    """Fill in the twist of the tick and the wheel speeds after it, for all bodies.

    Args:
        motors: float64[8, n], rows `MOTOR_TRACK` to `MOTOR_RIGHT_SCALE`.
        wheels: float64[2, n], wheel speeds at the start, m/s.
        power: float64[2, n], shares of full power in force, with the motors' noise.
        period: T, s.
        twist: float64[2, n], out: travel along the arc, m, and turn, rad.
        new_wheels: float64[2, n], out, m/s, as if nothing is in the way. May be `wheels` itself.
    """
    for i in range(motors.shape[1]):
        top = motors[MOTOR_TOP_SPEED, i]
        if top <= 0.0:
            twist[TRAVEL, i] = 0.0
            twist[TURN, i] = 0.0
            new_wheels[LEFT, i] = 0.0
            new_wheels[RIGHT, i] = 0.0
            continue
        kept, settling, acceleration = motors[MOTOR_KEPT, i], motors[MOTOR_SETTLING, i], motors[MOTOR_ACCELERATION, i]
        most_left, most_right = top * motors[MOTOR_LEFT_SCALE, i], top * motors[MOTOR_RIGHT_SCALE, i]
        left, rolled_left = wheel_cycle(
            wheels[LEFT, i], power[LEFT, i] * most_left, kept, settling, acceleration, most_left, period
        )
        right, rolled_right = wheel_cycle(
            wheels[RIGHT, i], power[RIGHT, i] * most_right, kept, settling, acceleration, most_right, period
        )
        track = motors[MOTOR_TRACK, i]
        travel = 0.5 * (rolled_left + rolled_right)
        turn = (rolled_right - rolled_left) / track
        rate = min(motors[MOTOR_TURN_RATE, i], _MOST_TURN_RATE)
        most = rate * period
        turn = min(max(turn, -most), most)
        if abs(right - left) > rate * track:
            # A turn limit scales the difference of the wheels and leaves their mean.
            mean = 0.5 * (left + right)
            half = 0.5 * rate * track if right > left else -0.5 * rate * track
            left, right = mean - half, mean + half
        twist[TRAVEL, i] = travel
        twist[TURN, i] = turn
        new_wheels[LEFT, i] = left
        new_wheels[RIGHT, i] = right
