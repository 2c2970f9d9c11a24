"""Wheel slip: how far the wheels of a blocked body roll on.

A body is blocked if it cannot make the motion of its wheels. Its wheels then roll as far as the body moved, plus the
share `Robot.Slip` of the motion that it could not make. With 0 the wheels stop with the body; with 1 they spin freely.

A body is stalled if it moved next to nothing. With 0 its wheels stop. Otherwise they follow the share `Slip` of their
power, with their lag and their limits, from no more than that share. So what they roll depends on how long the body is
pressed, and not on how many ticks that is.

Another model replaces the rows and the functions of this file. Parameters of a robot are fields of `Robot`. The
functions get the period of a tick, and the last two also get the tick, for a model that depends on time.
"""

from numba import njit

from intellwheels_schemas.messages import Robot
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.motor_model import (
    MOTOR_LEFT_SCALE,
    MOTOR_RIGHT_SCALE,
    MOTOR_TOP_SPEED,
    drive_one,
)
from intellwheels_server.world.kernels.motor_noise import MOTOR_NOISE_ROWS

# Rows of flaws, float64[FLAW_ROWS, n], behind those of the motors' noise.
SLIP = MOTOR_NOISE_ROWS
FLAW_ROWS = MOTOR_NOISE_ROWS + 1


def slip_figures(robot: Robot, _period: float) -> tuple[float, ...]:
    """Return the rows of flaws from `SLIP` to `FLAW_ROWS` for a robot: the share in [0, 1].

    Args:
        robot: The robot.
        _period: Simulated time of a tick, s.
    """
    return (robot.slip,)


@njit(cache=True, error_model="numpy")
def rolled_while_blocked(
    flaws: Floats, i: int, travel: float, turn: float, moved: float, turned: float, _tick: int, _period: float
) -> tuple[float, float]:
    """Return the travel, m, and the turn, rad, that the wheels of a blocked body rolled in a tick.

    Args:
        flaws: float64[FLAW_ROWS, n].
        i: The body.
        travel: Travel that its wheels wanted, m.
        turn: Turn that its wheels wanted, rad.
        moved: Travel of the body, m.
        turned: Turn of the body, rad.
        _tick: The tick that the step starts from.
        _period: Simulated time of the tick, s.
    """
    if flaws[SLIP, i] > 0.0:
        moved += flaws[SLIP, i] * (travel - moved)
        turned += flaws[SLIP, i] * (turn - turned)
    return moved, turned


@njit(cache=True, error_model="numpy")
def rolled_while_stalled(
    motors: Floats, flaws: Floats, keys: Ints, i: int, left: float, right: float, power_left: float,
    power_right: float, tick: int, period: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Return the wheel speeds of a stalled body after a tick, m/s, and the travel, m, and turn, rad, that they rolled.

    Args:
        motors: float64[MOTOR_ROWS, n], rows of `motor_model`.
        flaws: float64[FLAW_ROWS, n].
        keys: int64[2, n], bits of the noise keys.
        i: The body.
        left: Speed of the left wheel at the start, m/s.
        right: Speed of the right wheel at the start, m/s.
        power_left: Power in force.
        power_right: Power in force.
        tick: The tick that the step starts from.
        period: Simulated time of the tick, s.
    """
    share = flaws[SLIP, i]
    if share <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    power_left *= share
    power_right *= share
    most_left = abs(power_left) * motors[MOTOR_TOP_SPEED, i] * motors[MOTOR_LEFT_SCALE, i]
    most_right = abs(power_right) * motors[MOTOR_TOP_SPEED, i] * motors[MOTOR_RIGHT_SCALE, i]
    left = min(max(left, -most_left), most_left)
    right = min(max(right, -most_right), most_right)
    return drive_one(motors, flaws, keys, i, left, right, power_left, power_right, tick, period)
