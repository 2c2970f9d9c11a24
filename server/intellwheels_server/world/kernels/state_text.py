"""The bytes of the true state of all bodies, as JSON, written straight from the arrays of a state.

All numbers are rounded to 1e-6. `text` holds the fixed bytes; a fragment is a pair of its first byte and its end.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.measures_text import (
    Bytes,
    copy_text,
    motor_state,
    write_digits,
    write_heading,
    write_millionths,
)
from intellwheels_server.world.kernels.motor_model import MOTOR_LEFT_SCALE, MOTOR_TOP_SPEED

# Fragments, int64[FRAGMENTS, 2]: what stands before each field, and the end. The states of motors come last, in the
# order of `measures_text.STATES`.
NAME, AT_X, AT_Y, AT_HEADING, SPEED, TURN_RATE, LEFT_OUTPUT, RIGHT_OUTPUT, COLLISION, CONTACT, CONTACTS = range(11)
COMMAND_AGE, TRAVELLED, TURNED, END, STATES = 11, 12, 13, 14, 15

NUMBER_BYTES = 24 * 12
"""More bytes than all numbers of a body have."""


@njit(cache=True, error_model="numpy")
def _rounded(value: float, out: Bytes, at: int) -> int:
    scaled = np.rint(abs(value) * 1e6)
    if not scaled < 1e15:
        return -1
    return write_millionths(int(scaled), value < 0.0, out, at)


@njit(cache=True, error_model="numpy")
def _unless_zero(fragment: int, value: float, text: Bytes, fragments: Ints, out: Bytes, at: int) -> int:
    """Write a field that has the default 0; return the place behind it, or -1."""
    if at < 0 or np.rint(abs(value) * 1e6) == 0.0:
        return at
    return _rounded(value, out, copy_text(text, fragments[fragment, 0], fragments[fragment, 1], out, at))


@njit(cache=True, error_model="numpy")
def _always(fragment: int, value: float, text: Bytes, fragments: Ints, out: Bytes, at: int) -> int:
    """Write a field that has no default; return the place behind it, or -1."""
    if at < 0:
        return at
    return _rounded(value, out, copy_text(text, fragments[fragment, 0], fragments[fragment, 1], out, at))


@njit(cache=True, error_model="numpy")
def _output(motors: Floats, numbers: Floats, side: int, body: int) -> float:
    """Return the output of a motor: the speed of its wheel over that at full power, in [-1, 1]."""
    full = motors[MOTOR_TOP_SPEED, body] * motors[MOTOR_LEFT_SCALE + side, body]
    if not full > 0.0:
        return 0.0
    return float(min(max(numbers[rows.LEFT_SPEED + side, body] / full, -1.0), 1.0))


@njit(cache=True, error_model="numpy")
def write_entities(
    names: Bytes,
    name_ends: Ints,
    text: Bytes,
    fragments: Ints,
    more: Bytes,
    more_ends: Ints,
    ages: Floats,
    paths: Floats,
    motors: Floats,
    flags: Ints,
    numbers: Floats,
    out: Bytes,
    ends: Ints,
) -> bool:
    """Write all bodies, with a comma behind each; return whether all numbers could be written.

    Args:
        names: The names, one behind the other.
        name_ends: int64[n + 1], the end of each, behind a 0.
        text: Everything that is fixed.
        fragments: int64[STATES + 6, 2].
        more: The bytes of fields that are no numbers, one body behind the other.
        more_ends: int64[n + 1], the end of those of each body, behind a 0.
        ages: float64[n], the age of the commands of each body, s.
        paths: float64[2, n], the length of the path, m, and the angle turned, rad; NaN where they are not known.
        motors: Of the body set.
        flags: Of the state.
        numbers: Of the state.
        out: uint8[...], out; long enough.
        ends: int64[n + 1], out: the end of each body, behind a 0.
    """
    at = 0
    ends[0] = 0
    for body in range(numbers.shape[1]):
        at = copy_text(text, fragments[NAME, 0], fragments[NAME, 1], out, at)
        at = copy_text(names, name_ends[body], name_ends[body + 1], out, at)
        at = _always(AT_X, numbers[rows.X, body], text, fragments, out, at)
        at = _always(AT_Y, numbers[rows.Y, body], text, fragments, out, at)
        if at < 0:
            return False
        at = copy_text(text, fragments[AT_HEADING, 0], fragments[AT_HEADING, 1], out, at)
        at = write_heading(np.rint(numbers[rows.HEADING, body] * 1e6) / 1e6 + 0.0, out, at)
        at = _unless_zero(SPEED, numbers[rows.SPEED, body], text, fragments, out, at)
        at = _unless_zero(TURN_RATE, numbers[rows.TURN_RATE, body], text, fragments, out, at)
        at = _unless_zero(LEFT_OUTPUT, _output(motors, numbers, 0, body), text, fragments, out, at)
        at = _unless_zero(RIGHT_OUTPUT, _output(motors, numbers, 1, body), text, fragments, out, at)
        if at < 0:
            return False
        if flags[rows.COLLISION, body]:
            at = copy_text(text, fragments[COLLISION, 0], fragments[COLLISION, 1], out, at)
        if numbers[rows.TOUCHING, body] != 0.0:
            at = copy_text(text, fragments[CONTACT, 0], fragments[CONTACT, 1], out, at)
        if flags[rows.CONTACTS, body]:
            at = copy_text(text, fragments[CONTACTS, 0], fragments[CONTACTS, 1], out, at)
            at = write_digits(flags[rows.CONTACTS, body], out, at)
        state = STATES + motor_state(flags, body)
        at = copy_text(text, fragments[state, 0], fragments[state, 1], out, at)
        at = copy_text(more, more_ends[body], more_ends[body + 1], out, at)
        at = _unless_zero(COMMAND_AGE, ages[body], text, fragments, out, at)
        if not math.isnan(paths[0, body]):
            at = _always(TRAVELLED, paths[0, body], text, fragments, out, at)
            at = _always(TURNED, paths[1, body], text, fragments, out, at)
        if at < 0:
            return False
        at = copy_text(text, fragments[END, 0], fragments[END, 1], out, at)
        ends[body + 1] = at
    return True
