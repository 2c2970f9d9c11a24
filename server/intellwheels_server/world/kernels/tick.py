"""One step of all bodies, in one call: powers, motors, contact, wheels."""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import (
    BLOCKED,
    CONTACT,
    END_HEADING,
    END_X,
    END_Y,
    FORWARD,
    HIT_BODY,
    HIT_OTHER,
    HIT_WALL,
    KEY,
    STALLED,
    TRAVEL,
    TURN,
    TURNED,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.arrays import COLLISION as HIT_SOMETHING
from intellwheels_server.world.kernels.arrays import LICENCE as END_LICENCE
from intellwheels_server.world.kernels.command import REAL, SLIP, noisy_powers, powers
from intellwheels_server.world.kernels.contact import decree, overlaps, resolve
from intellwheels_server.world.kernels.geometry import arc
from intellwheels_server.world.kernels.motion import LEFT, RIGHT, TRACK, drive
from intellwheels_server.world.kernels.rows import (
    COLLISION,
    HEADING,
    LEFT_SPEED,
    LEFT_TRAVEL,
    LICENCE,
    MOST_SPEED,
    MOST_TURN_RATE,
    RIGHT_SPEED,
    RIGHT_TRAVEL,
    SPEED,
    TOUCHING,
    TURN_RATE,
    WALL_KEY,
    WORLD_EDGE,
    X,
    Y,
)

_ROOM = 16


@njit(cache=True, error_model="numpy")
def _hold_inside(pose: Floats, wheels: Floats, twist: Floats) -> None:
    """Take their travel from bodies whose arc would lead beyond the edge of the world; they may turn and come back."""
    for i in range(pose.shape[1]):
        reach = abs(twist[TRAVEL, i])
        if abs(pose[X, i]) + reach > WORLD_EDGE or abs(pose[Y, i]) + reach > WORLD_EDGE:
            x, y, _, _, _ = arc(pose[X, i], pose[Y, i], pose[HEADING, i], twist[TRAVEL, i], twist[TURN, i])
            if abs(x) > WORLD_EDGE or abs(y) > WORLD_EDGE:
                twist[TRAVEL, i] = 0.0
                mean = 0.5 * (wheels[LEFT, i] + wheels[RIGHT, i])
                wheels[LEFT, i] -= mean
                wheels[RIGHT, i] -= mean


@njit(cache=True, error_model="numpy")
def tick_all(
    parts: Floats,
    part_start: Ints,
    shape: Floats,
    marks: Ints,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
    motors: Floats,
    flaws: Floats,
    noise: Ints,
    limits: Ints,
    numbers: Floats,
    flags: Ints,
    reported: Ints,
    tick: int,
    period: float,
    silence: int,
    staleness: int,
) -> tuple[int, Ints, Floats]:
    """Move all bodies by one tick.

    Args:
        parts: Of the bodies, as the next three: see `arrays.Bodies`.
        part_start: Of the bodies.
        shape: Of the bodies.
        marks: Of the bodies.
        pieces: Of the walls, as the next four: see `arrays.Walls`.
        links: Of the walls.
        edges: Of the walls.
        cells: Of the walls.
        frame: Of the walls.
        motors: float64[8, n], rows of `motion`.
        flaws: float64[2, n], rows of `command`.
        noise: int64[2, n], bits of the motors' noise keys.
        limits: int64[2, n], rows of `command`.
        numbers: float64[NUMBER_ROWS, n], in and out, what was latched already in it.
        flags: int64[FLAG_ROWS, n], in and out.
        reported: int64[k], columns of real bodies whose pose was reported for this step, ascending.
        tick: The tick that the step starts from.
        period: s.
        silence: Steps after which a user is silent, -1 for never.
        staleness: Steps after which a real body's pose is stale, -1 for never.

    Returns:
        What `command.powers` found; the pairs that touched and their numbers, columns of `arrays`' hit blocks.
    """
    count = numbers.shape[1]
    found = powers(numbers, flags, motors, limits, silence, staleness)
    pose = numbers[X : HEADING + 1]
    licence = numbers[LICENCE].copy()
    if reported.shape[0] > 0:
        decree(parts, part_start, shape, marks, pieces, links, edges, cells, frame, pose, reported, licence)

    power = np.empty((2, count))
    noisy_powers(numbers, flaws, noise, tick, power)
    twist = np.empty((2, count))
    wheels = numbers[LEFT_SPEED : RIGHT_SPEED + 1]
    drive(motors, wheels, power, period, twist, wheels)
    _hold_inside(pose, wheels, twist)

    outcome = np.empty((6, count))
    marks_out = np.empty((4, count), dtype=np.int64)
    room = _ROOM + count
    while True:
        hits = np.empty((room, 6), dtype=np.int64)
        hit_numbers = np.empty((room, 6))
        used = resolve(
            parts, part_start, shape, marks, pieces, links, edges, cells, frame, pose, twist, licence, tick,
            outcome, marks_out, hits, hit_numbers,
        )  # fmt: skip
        if reported.shape[0] > 0 and used <= room:
            used += overlaps(
                parts, part_start, shape, marks, pieces, links, edges, cells, frame, outcome[: HEADING + 1], reported,
                hits[used:], hit_numbers[used:],
            )  # fmt: skip
        if used <= room:
            break
        room = used + _ROOM

    for i in range(count):
        numbers[TOUCHING, i] = 1.0 if marks_out[CONTACT, i] != 0 else 0.0
        flags[COLLISION, i] = 1 if marks_out[HIT_SOMETHING, i] != 0 else 0
        numbers[LICENCE, i] = outcome[END_LICENCE, i]
        if limits[REAL, i] != 0:
            continue
        numbers[X, i] = outcome[END_X, i]
        numbers[Y, i] = outcome[END_Y, i]
        numbers[HEADING, i] = outcome[END_HEADING, i]
        forward = outcome[FORWARD, i]
        turned = outcome[TURNED, i]
        numbers[SPEED, i] = min(max(forward / period, -MOST_SPEED), MOST_SPEED)
        numbers[TURN_RATE, i] = min(max(turned / period, -MOST_TURN_RATE), MOST_TURN_RATE)
        if marks_out[BLOCKED, i] != 0 and flaws[SLIP, i] > 0.0:
            forward += flaws[SLIP, i] * (twist[TRAVEL, i] - forward)
            turned += flaws[SLIP, i] * (twist[TURN, i] - turned)
        half = 0.5 * turned * motors[TRACK, i]
        numbers[LEFT_TRAVEL, i] += forward - half
        numbers[RIGHT_TRAVEL, i] += forward + half
        if marks_out[STALLED, i] != 0:
            numbers[LEFT_SPEED, i] = 0.0
            numbers[RIGHT_SPEED, i] = 0.0
    for k in range(used):
        # What a real body was moved into counts as touched by both.
        body, other = hits[k, HIT_BODY], hits[k, HIT_OTHER]
        numbers[TOUCHING, body] = 1.0
        if limits[REAL, body] != 0:
            flags[COLLISION, body] = 1
        if other >= 0:
            numbers[TOUCHING, other] = 1.0
            if limits[REAL, other] != 0:
                flags[COLLISION, other] = 1
    return found, hits[:used], hit_numbers[:used]


@njit(cache=True, error_model="numpy")
def pair_keys(hits: Ints, marks: Ints) -> Ints:
    """Return int64[hits, 3]: the keys of both of each pair, the lower first and `WALL_KEY` for a wall, and its row."""
    pairs = np.empty((hits.shape[0], 3), dtype=np.int64)
    for k in range(hits.shape[0]):
        first = marks[KEY, hits[k, HIT_BODY]]
        second = np.int64(WALL_KEY)
        if hits[k, HIT_WALL] < 0:
            second = marks[KEY, hits[k, HIT_OTHER]]
            if second < first:
                first, second = second, first
        pairs[k, 0] = first
        pairs[k, 1] = second
        pairs[k, 2] = k
    return pairs
