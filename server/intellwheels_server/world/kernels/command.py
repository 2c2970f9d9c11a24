"""Which power is in force: the command, the user's wish, or nothing."""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.motion import LEFT, RIGHT, TOP_SPEED
from intellwheels_server.world.kernels.noise import normal
from intellwheels_server.world.kernels.rows import (
    COMMAND_AGE,
    HALTED,
    LEFT_COMMAND,
    LEFT_POWER,
    POSE_AGE,
    RESTED,
    RIGHT_COMMAND,
    RIGHT_POWER,
    SILENT,
    STALE,
    TAKEN,
    TIMED_OUT,
    USER_AGE,
    USER_FORWARD,
    USER_TURN,
)

# Rows of limits, int64[2, n]: steps until a command times out; 1 for a real body.
TIMEOUT, REAL = 0, 1
# Rows of flaws, float64[2, n]: standard deviation of a motor's output, as a share; share by which blocked wheels turn
# on.
NOISE, SLIP = 0, 1

# What `powers` found changed, as bits, so that a tick in which nothing did costs no look.
NOW_TIMED_OUT, NOW_SILENT, NOW_STALE = 1, 2, 4


@njit(cache=True, error_model="numpy")
def user_power(forward: float, turn: float) -> tuple[float, float]:
    """Return the powers of both wheels for a user's wish.

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
        motors: float64[8, n], rows of `motion`.
        limits: int64[2, n].
        silence: Steps after which a user counts as silent, or -1 where verdicts say so.
        staleness: Steps after which a real body's pose is stale, or -1 likewise.

    Returns:
        Bits `NOW_TIMED_OUT`, `NOW_SILENT`, `NOW_STALE` of what became so for some body.
    """
    found = 0
    for i in range(numbers.shape[1]):
        if silence >= 0 and flags[SILENT, i] == 0 and flags[USER_AGE, i] >= silence:
            flags[SILENT, i] = 1
            found |= NOW_SILENT
        if flags[SILENT, i] != 0:
            numbers[USER_FORWARD, i] = 0.0
            numbers[USER_TURN, i] = 0.0
        if limits[REAL, i] != 0 and staleness >= 0 and flags[STALE, i] == 0 and flags[POSE_AGE, i] >= staleness:
            flags[STALE, i] = 1
            found |= NOW_STALE
        timed_out = motors[TOP_SPEED, i] > 0.0 and flags[COMMAND_AGE, i] >= limits[TIMEOUT, i]
        if timed_out and flags[TIMED_OUT, i] == 0:
            flags[TIMED_OUT, i] = 1
            if numbers[LEFT_COMMAND, i] != 0.0 or numbers[RIGHT_COMMAND, i] != 0.0:
                found |= NOW_TIMED_OUT
        elif not timed_out:
            flags[TIMED_OUT, i] = 0
        left = numbers[LEFT_COMMAND, i]
        right = numbers[RIGHT_COMMAND, i]
        if flags[HALTED, i] != 0 or flags[STALE, i] != 0:
            left = right = 0.0
        elif flags[TAKEN, i] != 0:
            left, right = user_power(numbers[USER_FORWARD, i], numbers[USER_TURN, i])
        elif flags[RESTED, i] != 0 or timed_out:
            left = right = 0.0
        numbers[LEFT_POWER, i] = left
        numbers[RIGHT_POWER, i] = right
        flags[COMMAND_AGE, i] += 1
        flags[USER_AGE, i] += 1
        flags[POSE_AGE, i] += 1
    return found


@njit(cache=True, error_model="numpy")
def noisy_powers(numbers: Floats, flaws: Floats, keys: Ints, tick: int, power: Floats) -> None:
    """Fill in what the motors give for the power in force.

    Each motor's output is multiplied by 1 + sd x a standard normal number of its own, drawn anew each tick.

    Args:
        numbers: float64[NUMBER_ROWS, n].
        flaws: float64[2, n].
        keys: int64[2, n], bits of the noise keys.
        tick: This tick.
        power: float64[2, n], out.
    """
    for i in range(numbers.shape[1]):
        power[LEFT, i] = numbers[LEFT_POWER, i]
        power[RIGHT, i] = numbers[RIGHT_POWER, i]
        sd = flaws[NOISE, i]
        if sd > 0.0:
            key0, key1 = np.uint64(keys[0, i]), np.uint64(keys[1, i])
            power[LEFT, i] *= 1.0 + sd * normal(key0, key1, tick, 0)
            power[RIGHT, i] *= 1.0 + sd * normal(key0, key1, tick, 1)
