"""Wheel slip: how far the wheels of a blocked body roll on.

A body that cannot move as its wheels want is blocked. Its wheels then roll what the body moved, and of the motion that
it was denied the share `Robot.Slip`: 0 for wheels that stop with the body, 1 for wheels that spin freely.

Another model replaces the rows and the two functions of this file. What else it needs of a robot is a field of `Robot`.
Both functions are given the period of a tick, and the second the tick, for a model that depends on time.
"""

from numba import njit

from intellwheels_schemas.messages import Robot
from intellwheels_server.world.kernels.arrays import Floats
from intellwheels_server.world.kernels.motor_power import MOTOR_NOISE_ROWS

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
        travel: What its wheels wanted, m.
        turn: What its wheels wanted, rad.
        moved: What the body did, m.
        turned: What the body did, rad.
        _tick: The tick that the step starts from.
        _period: Simulated time of the tick, s.
    """
    if flaws[SLIP, i] > 0.0:
        moved += flaws[SLIP, i] * (travel - moved)
        turned += flaws[SLIP, i] * (turn - turned)
    return moved, turned
