"""The bytes of messages with readings, written straight from the samples of all bodies.

What is the same at every tick is written once, when a body joins: `text` holds all such bytes, and a fragment is a pair
of its first byte and its end. A form is one way in which a reading is written, as steps: a fragment, then a number of
the sample or the tick at which it was taken.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from numba import njit

from intellwheels_schemas.messages import MotorState
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints

Bytes = npt.NDArray[np.uint8]

# Rows of readers, int64[7, n]: column in the state; first of its samples and tick at which it joined; first sensor and
# end; fragment with its name, which may be empty.
COLUMN, BEGIN, JOINED, FIRST_SENSOR, END_SENSOR, NAME_BEGIN, NAME_END = 0, 1, 2, 3, 4, 5, 6
READER_ROWS = 7

# Columns of sensors, int64[sensors, 12]: place of the first sample among those of the body, numbers in a sample,
# samples kept, and schedule, as `sample_schedule` has them; number of its list; fragment that begins the list; count of
# codes of the first number in a sample, 0 if that is no code, and the lowest code; first form. Each code has two forms:
# for a sample of this tick, and for an older one.
FIRST, WIDTH, DEPTH, EVERY, LATENCY, PHASE, LIST, LIST_BEGIN, LIST_END, CODES, LOWEST, FORM = range(12)
SENSOR_COLUMNS = 12

# Columns of steps, int64[steps, 4]: fragment, what follows it, and which number of the sample that is.
STEP_BEGIN, STEP_END, WHAT, NUMBER = 0, 1, 2, 3

NOTHING, TICK, DECIMAL, HEADING, WHOLE = 0, 1, 2, 3, 4
"""What follows a fragment: the end of the form; the tick of the sample; a number; a heading; a whole number."""

# Fragments of a frame, int64[6 + 24, 2]: before and after all readings; what closes a list; what separates readings,
# and lists; the end; then every combination of flags, as `_mark` numbers them.
OPEN, CLOSE, LIST_CLOSE, SEPARATOR, LIST_SEPARATOR, EMPTY, MARKS = 0, 1, 2, 3, 4, 5, 6

# States of motors, in the order of `observations`.
STALE_STATE, HALTED_STATE, TAKEN_STATE, RESTED_STATE, TIMED_OUT_STATE, DRIVE_STATE = 0, 1, 2, 3, 4, 5
STATES: tuple[MotorState, ...] = ("stale", "paused", "taken", "rested", "timeout", "drive")

LONGEST_NUMBER = 24
"""More bytes than any number that is written here has."""

# Below this, a multiple of 1e-6 has at most 15 digits, so its decimal form is the shortest one that names the number.
_MOST = 1e9
_MILLION = 1_000_000
_ZERO, _MINUS, _POINT = 48, 45, 46


@njit(cache=True, error_model="numpy", inline="always")
def copy_text(text: Bytes, begin: int, end: int, out: Bytes, at: int) -> int:
    """Write a fragment and return the place behind it."""
    for k in range(begin, end):
        out[at] = text[k]
        at += 1
    return at


@njit(cache=True, error_model="numpy")
def write_digits(number: int, out: Bytes, at: int) -> int:
    """Write a whole number, not negative, and return the place behind it."""
    size = 1
    rest = number // 10
    while rest > 0:
        size += 1
        rest //= 10
    for k in range(at + size - 1, at - 1, -1):
        out[k] = _ZERO + number % 10
        number //= 10
    return at + size


@njit(cache=True, error_model="numpy")
def _decimal(value: float, out: Bytes, at: int) -> int:
    """Write a multiple of 1e-6 as the codec writes it, and return the place behind it, or -1 if it is none."""
    size = abs(value)
    if not size < _MOST or (value == 0.0 and math.copysign(1.0, value) < 0.0):
        return -1
    scaled = int(np.rint(size * 1e6))
    if scaled / 1e6 != size:
        return -1
    return write_millionths(scaled, value < 0.0, out, at)


@njit(cache=True, error_model="numpy")
def write_millionths(scaled: int, negative: bool, out: Bytes, at: int) -> int:
    """Write a number of millionths below 1e15 as the codec writes it, and return the place behind it."""
    if negative and scaled > 0:
        out[at] = _MINUS
        at += 1
    if 0 < scaled < 10:  # the codec writes 0.00001, but 9e-6
        out[at] = _ZERO + scaled
        out[at + 1], out[at + 2], out[at + 3] = 101, 45, 54
        return at + 4
    at = write_digits(scaled // _MILLION, out, at)
    out[at] = _POINT
    at += 1
    rest = scaled % _MILLION
    place = _MILLION // 10
    while True:
        out[at] = _ZERO + rest // place
        at += 1
        rest %= place
        if rest == 0:
            return at
        place //= 10


@njit(cache=True, error_model="numpy")
def _whole(value: float, out: Bytes, at: int) -> int:
    """Write a whole number, and return the place behind it, or -1 if it is none."""
    if not abs(value) <= 9007199254740992.0 or np.floor(value) != value:
        return -1
    if value < 0.0:
        out[at] = _MINUS
        at += 1
    return write_digits(int(abs(value)), out, at)


@njit(cache=True, error_model="numpy")
def write_heading(value: float, out: Bytes, at: int) -> int:
    """Write a heading; one that rounding took out of (-pi, pi] is written as pi, as `angles.written_heading` says."""
    if -math.pi < value <= math.pi:
        return _decimal(value, out, at)
    digits = 3141592653589793
    after = write_digits(digits, out, at + 1)
    out[at] = out[at + 1]
    out[at + 1] = _POINT
    return after


@njit(cache=True, error_model="numpy", inline="always")
def motor_state(flags: Ints, body: int) -> int:
    """Return the state of the motors of a body, an index of `STATES`."""
    if flags[rows.STALE, body]:
        return STALE_STATE
    if flags[rows.HALTED, body]:
        return HALTED_STATE
    if flags[rows.TAKEN, body]:
        return TAKEN_STATE
    if flags[rows.RESTED, body]:
        return RESTED_STATE
    if flags[rows.TIMED_OUT, body]:
        return TIMED_OUT_STATE
    return DRIVE_STATE


@njit(cache=True, error_model="numpy", inline="always")
def _mark(flags: Ints, numbers: Floats, body: int) -> int:
    """Return the number of a combination of flags: the collision, the contact, and the state of the motors."""
    state = motor_state(flags, body)
    return 4 * state + 2 * int(numbers[rows.TOUCHING, body] != 0.0) + int(flags[rows.COLLISION, body] != 0)


@njit(cache=True, error_model="numpy")
def _reading(
    tick: int, late: int, place: int, form: int, forms: Ints, steps: Ints, samples: Floats, text: Bytes, out: Bytes,
    at: int,
) -> int:  # fmt: skip
    """Write a reading, and return the place behind it, or -1 if a number cannot be written."""
    for step in range(forms[form], steps.shape[0]):
        at = copy_text(text, steps[step, STEP_BEGIN], steps[step, STEP_END], out, at)
        what = steps[step, WHAT]
        if what == NOTHING:
            return at
        if what == TICK:
            at = write_digits(tick - late, out, at)
            continue
        value = samples[place + steps[step, NUMBER]]
        if what == DECIMAL:
            at = _decimal(value, out, at)
        elif what == HEADING:
            at = write_heading(value, out, at)
        else:
            at = _whole(value, out, at)
        if at < 0:
            return -1
    return -1


@njit(cache=True, error_model="numpy")
def _readings(
    tick: int, begin: int, joined: int, first: int, end: int, sensors: Ints, forms: Ints, steps: Ints, frame: Ints,
    samples: Floats, text: Bytes, out: Bytes, at: int,
) -> int:  # fmt: skip
    """Write the readings of a body, or nothing if it has none; return the place behind, or -1."""
    current = -1
    for sensor in range(first, end):
        age = tick - sensors[sensor, LATENCY] - joined - sensors[sensor, PHASE]
        if age < 0:
            continue
        every = sensors[sensor, EVERY]
        number, rest = age // every, age % every
        late = sensors[sensor, LATENCY] + rest
        place = begin + sensors[sensor, FIRST] + number % sensors[sensor, DEPTH] * sensors[sensor, WIDTH]
        code = 0
        if sensors[sensor, CODES] > 0:
            code = int(samples[place]) - sensors[sensor, LOWEST]
            if not 0 <= code < sensors[sensor, CODES]:
                return -1
        if sensors[sensor, LIST] == current:
            at = copy_text(text, frame[SEPARATOR, 0], frame[SEPARATOR, 1], out, at)
        else:
            if current < 0:
                at = copy_text(text, frame[OPEN, 0], frame[OPEN, 1], out, at)
            else:
                at = copy_text(text, frame[LIST_CLOSE, 0], frame[LIST_CLOSE, 1], out, at)
                at = copy_text(text, frame[LIST_SEPARATOR, 0], frame[LIST_SEPARATOR, 1], out, at)
            at = copy_text(text, sensors[sensor, LIST_BEGIN], sensors[sensor, LIST_END], out, at)
            current = sensors[sensor, LIST]
        form = sensors[sensor, FORM] + 2 * code + (1 if late > 0 else 0)
        at = _reading(tick, late, place, form, forms, steps, samples, text, out, at)
        if at < 0:
            return -1
    ending = EMPTY
    if current >= 0:
        at = copy_text(text, frame[LIST_CLOSE, 0], frame[LIST_CLOSE, 1], out, at)
        ending = CLOSE
    return copy_text(text, frame[ending, 0], frame[ending, 1], out, at)


@njit(cache=True, error_model="numpy")
def write_measures(
    tick: int,
    name_first: bool,
    head: Bytes,
    tail: Bytes,
    readers: Ints,
    sensors: Ints,
    forms: Ints,
    steps: Ints,
    frame: Ints,
    text: Bytes,
    flags: Ints,
    numbers: Floats,
    samples: Floats,
    out: Bytes,
    ends: Ints,
) -> None:
    """Write the measures of some bodies at a tick, one behind the other.

    Args:
        tick: The tick.
        name_first: Whether the name stands before the readings, else behind them.
        head: The bytes with which all of them begin.
        tail: The bytes with which all of them end.
        readers: int64[READER_ROWS, n].
        sensors: int64[sensors, SENSOR_COLUMNS].
        forms: int64[forms], the first step of each.
        steps: int64[steps, 4].
        frame: int64[MARKS + 24, 2].
        text: Everything that is fixed.
        flags: Of the state.
        numbers: Of the state.
        samples: Of the state, those of this tick included.
        out: uint8[...], out; long enough for the longest message of each body.
        ends: int64[n + 1], out: where each message ends, behind the place 0 where the first begins. A message without
            bytes has a number that cannot be written here.
    """
    at = 0
    ends[0] = 0
    for reader in range(readers.shape[1]):
        body = readers[COLUMN, reader]
        start = at
        at = copy_text(head, 0, head.shape[0], out, at)
        mark = MARKS + _mark(flags, numbers, body)
        at = copy_text(text, frame[mark, 0], frame[mark, 1], out, at)
        if name_first:
            at = copy_text(text, readers[NAME_BEGIN, reader], readers[NAME_END, reader], out, at)
        at = _readings(
            tick, readers[BEGIN, reader], readers[JOINED, reader], readers[FIRST_SENSOR, reader],
            readers[END_SENSOR, reader], sensors, forms, steps, frame, samples, text, out, at,
        )  # fmt: skip
        if at < 0:
            at = start
        else:
            if not name_first:
                at = copy_text(text, readers[NAME_BEGIN, reader], readers[NAME_END, reader], out, at)
            at = copy_text(tail, 0, tail.shape[0], out, at)
        ends[reader + 1] = at
