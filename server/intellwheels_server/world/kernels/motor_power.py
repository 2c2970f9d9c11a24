"""The power in force: the command, the user's input, or none."""

from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.motor_model import MOTOR_TOP_SPEED

# Rows of limits, int64[2, n]: steps until a command times out; 1 for a real body.
TIMEOUT, REAL = 0, 1

# The changes that `powers` found, as bits, so that a tick without changes needs no search.
NOW_TIMED_OUT, NOW_SILENT, NOW_STALE = 1, 2, 4


@njit(cache=True, error_model="numpy")
def user_power(forward: float, turn: float) -> tuple[float, float]:
    """Return the powers of both wheels for the forward and turn that a user wants.

    left = F - T and right = F + T, both divided by max(1, |left|, |right|).
    """
    left = forward - turn
    right = forward + turn
    scale = max(1.0, abs(left), abs(right))
    return left / scale, right / scale


@njit(cache=True, error_model="numpy")
def powers(
    numbers: Floats,
    flags: Ints,
    motors: Floats,
    limits: Ints,
    silence: int,
    staleness: int,
) -> int:
    """Fill in the power in force of every body, and count how old commands, user input and poses are.

    Args:
        numbers: float64[NUMBER_ROWS, n], in and out.
        flags: int64[FLAG_ROWS, n], in and out; ages count the step that begins.
        motors: float64[MOTOR_ROWS, n], rows of `motor_model`.
        limits: int64[2, n].
        silence: Steps after which a user counts as silent, or -1 if verdicts decide it.
        staleness: Steps after which the pose of a real body is stale, or -1 if verdicts decide it.

    Returns:
        Bits `NOW_TIMED_OUT`, `NOW_SILENT`, `NOW_STALE`, each set if this has just begun for some body.
    """
    found = 0
    for i in range(numbers.shape[1]):
        if silence >= 0 and flags[rows.SILENT, i] == 0 and flags[rows.USER_AGE, i] >= silence:
            flags[rows.SILENT, i] = 1
            found |= NOW_SILENT
        if flags[rows.SILENT, i] != 0:
            numbers[rows.USER_FORWARD, i] = 0.0
            numbers[rows.USER_TURN, i] = 0.0
        if (
            limits[REAL, i] != 0
            and staleness >= 0
            and flags[rows.STALE, i] == 0
            and flags[rows.POSE_AGE, i] >= staleness
        ):
            flags[rows.STALE, i] = 1
            found |= NOW_STALE
        timed_out = motors[MOTOR_TOP_SPEED, i] > 0.0 and flags[rows.COMMAND_AGE, i] >= limits[TIMEOUT, i]
        if timed_out and flags[rows.TIMED_OUT, i] == 0:
            flags[rows.TIMED_OUT, i] = 1
            if numbers[rows.LEFT_COMMAND, i] != 0.0 or numbers[rows.RIGHT_COMMAND, i] != 0.0:
                found |= NOW_TIMED_OUT
        elif not timed_out:
            flags[rows.TIMED_OUT, i] = 0
        left = numbers[rows.LEFT_COMMAND, i]
        right = numbers[rows.RIGHT_COMMAND, i]
        if flags[rows.HALTED, i] != 0 or flags[rows.STALE, i] != 0:
            left = right = 0.0
        elif flags[rows.TAKEN, i] != 0:
            left, right = user_power(numbers[rows.USER_FORWARD, i], numbers[rows.USER_TURN, i])
        elif flags[rows.RESTED, i] != 0 or timed_out:
            left = right = 0.0
        numbers[rows.LEFT_POWER, i] = left
        numbers[rows.RIGHT_POWER, i] = right
        flags[rows.COMMAND_AGE, i] += 1
        flags[rows.USER_AGE, i] += 1
        flags[rows.POSE_AGE, i] += 1
    return found
