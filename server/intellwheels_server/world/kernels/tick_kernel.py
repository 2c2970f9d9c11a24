"""One step of all bodies, in one call: powers, motors, contact, wheels.

The call from Python takes every array on its own. Passing 13 of them in three named tuples costs 2 us more per call, a
fifth of the step of one body. Inside, arrays that always travel together are packed into named tuples.
"""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.allowed_penetration import allow_overlap, record_overlaps
from intellwheels_server.world.kernels.arrays import (
    BLOCKED,
    COLLIDED,
    END_ALLOWED,
    END_HEADING,
    END_X,
    END_Y,
    FORWARD,
    HIT_BODY,
    HIT_OTHER,
    HIT_WALL,
    KEY,
    STALLED,
    TOUCHED,
    TRAVEL,
    TURN,
    TURNED,
    Bodies,
    Floats,
    Ints,
    Walls,
)
from intellwheels_server.world.kernels.contact import resolve
from intellwheels_server.world.kernels.contact_hits import Outcomes
from intellwheels_server.world.kernels.geometry import arc
from intellwheels_server.world.kernels.motor_model import LEFT, MOTOR_TRACK, RIGHT, drive
from intellwheels_server.world.kernels.motor_power import REAL, powers
from intellwheels_server.world.kernels.wheel_slip import SLIP, rolled_while_blocked, rolled_while_stalled

_ROOM = 16


@njit(cache=True, error_model="numpy")
def _stay_inside(pose: Floats, wheels: Floats, twist: Floats) -> None:
    """Set the travel to 0 for bodies whose arc leads beyond the edge of the world. They may turn and come back."""
    for i in range(pose.shape[1]):
        reach = abs(twist[TRAVEL, i])
        if abs(pose[rows.X, i]) + reach > rows.WORLD_EDGE or abs(pose[rows.Y, i]) + reach > rows.WORLD_EDGE:
            x, y, _, _, _ = arc(
                pose[rows.X, i], pose[rows.Y, i], pose[rows.HEADING, i], twist[TRAVEL, i], twist[TURN, i]
            )
            if abs(x) > rows.WORLD_EDGE or abs(y) > rows.WORLD_EDGE:
                twist[TRAVEL, i] = 0.0
                mean = 0.5 * (wheels[LEFT, i] + wheels[RIGHT, i])
                wheels[LEFT, i] -= mean
                wheels[RIGHT, i] -= mean


@njit(cache=True, error_model="numpy", inline="always")
def _take_over(
    outcome: Floats, outcome_flags: Ints, twist: Floats, motors: Floats, flaws: Floats, noise: Ints, limits: Ints,
    before: Floats, tick: int, period: float, numbers: Floats, flags: Ints,
) -> None:  # fmt: skip
    """Write the outcome of contact into the state: poses, speeds, and how far the wheels rolled."""
    for i in range(numbers.shape[1]):
        numbers[rows.TOUCHING, i] = 1.0 if outcome_flags[TOUCHED, i] != 0 else 0.0
        flags[rows.COLLISION, i] = 1 if outcome_flags[COLLIDED, i] != 0 else 0
        numbers[rows.ALLOWED_PENETRATION, i] = outcome[END_ALLOWED, i]
        if limits[REAL, i] != 0:
            continue
        numbers[rows.X, i] = outcome[END_X, i]
        numbers[rows.Y, i] = outcome[END_Y, i]
        numbers[rows.HEADING, i] = outcome[END_HEADING, i]
        forward, turned = outcome[FORWARD, i], outcome[TURNED, i]
        numbers[rows.SPEED, i] = min(max(forward / period, -rows.MOST_SPEED), rows.MOST_SPEED)
        numbers[rows.TURN_RATE, i] = min(max(turned / period, -rows.MOST_TURN_RATE), rows.MOST_TURN_RATE)
        if outcome_flags[STALLED, i] != 0:
            left, right, spun, spun_turn = rolled_while_stalled(
                motors, flaws, noise, i, before[LEFT, i], before[RIGHT, i], numbers[rows.LEFT_POWER, i],
                numbers[rows.RIGHT_POWER, i], tick, period,
            )  # fmt: skip
            numbers[rows.LEFT_SPEED, i], numbers[rows.RIGHT_SPEED, i] = left, right
            if flaws[SLIP, i] > 0.0:
                forward = spun + (1.0 - flaws[SLIP, i]) * forward
                turned = spun_turn + (1.0 - flaws[SLIP, i]) * turned
        elif outcome_flags[BLOCKED, i] != 0:
            forward, turned = rolled_while_blocked(
                flaws, i, twist[TRAVEL, i], twist[TURN, i], forward, turned, tick, period
            )
        half = 0.5 * turned * motors[MOTOR_TRACK, i]
        numbers[rows.LEFT_TRAVEL, i] += forward - half
        numbers[rows.RIGHT_TRAVEL, i] += forward + half


@njit(cache=True, error_model="numpy", inline="always")
def _flag_touched(hits: Ints, used: int, limits: Ints, numbers: Floats, flags: Ints) -> None:
    """Flag both bodies of each hit as touched, and a real body as collided, since such a hit counts for both."""
    for k in range(used):
        body, other = hits[k, HIT_BODY], hits[k, HIT_OTHER]
        numbers[rows.TOUCHING, body] = 1.0
        if limits[REAL, body] != 0:
            flags[rows.COLLISION, body] = 1
        if other >= 0:
            numbers[rows.TOUCHING, other] = 1.0
            if limits[REAL, other] != 0:
                flags[rows.COLLISION, other] = 1


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
        motors: float64[MOTOR_ROWS, n], rows of `motor_model`.
        flaws: float64[FLAW_ROWS, n], rows of `motor_noise` and `wheel_slip`.
        noise: int64[2, n], bits of the motors' noise keys.
        limits: int64[2, n], rows of `motor_power`.
        numbers: float64[NUMBER_ROWS, n], in and out; the inputs of the step are in it.
        flags: int64[FLAG_ROWS, n], in and out.
        reported: int64[k], columns of real bodies whose pose was reported for this step, ascending.
        tick: The tick that the step starts from.
        period: s.
        silence: Steps after which a user is silent, -1 for never.
        staleness: Steps after which a real body's pose is stale, -1 for never.

    Returns:
        The bits of `motor_power.powers`; the pairs that touched and their numbers, as hit blocks of `arrays`.
    """
    bodies, walls = Bodies(parts, part_start, shape, marks), Walls(pieces, links, edges, cells, frame)
    count = numbers.shape[1]
    found = powers(numbers, flags, motors, limits, silence, staleness)
    pose = numbers[rows.X : rows.HEADING + 1]
    allowed = numbers[rows.ALLOWED_PENETRATION].copy()
    if reported.shape[0] > 0:
        allow_overlap(bodies, walls, pose, reported, allowed)

    twist = np.empty((2, count))
    wheels = numbers[rows.LEFT_SPEED : rows.RIGHT_SPEED + 1]
    before = wheels.copy()
    drive(motors, flaws, noise, before, numbers[rows.LEFT_POWER : rows.RIGHT_POWER + 1], tick, period, twist, wheels)
    _stay_inside(pose, wheels, twist)

    outcome = np.empty((6, count))
    outcome_flags = np.empty((4, count), dtype=np.int64)
    room = _ROOM + count
    while True:
        hits, hit_numbers = np.empty((room, 6), dtype=np.int64), np.empty((room, 6))
        outcomes = Outcomes(outcome, outcome_flags, hits, hit_numbers)
        used = resolve(bodies, walls, pose, twist, allowed, tick, outcomes)
        if reported.shape[0] > 0 and used <= room:
            after = outcome[: rows.HEADING + 1]
            used += record_overlaps(bodies, walls, after, reported, hits[used:], hit_numbers[used:])
        if used <= room:
            break
        room = used + _ROOM

    _take_over(outcome, outcome_flags, twist, motors, flaws, noise, limits, before, tick, period, numbers, flags)
    _flag_touched(hits, used, limits, numbers, flags)
    return found, hits[:used], hit_numbers[:used]


@njit(cache=True, error_model="numpy")
def pair_keys(hits: Ints, marks: Ints) -> Ints:
    """Return int64[hits, 3]: the keys of both of each pair, the lower first and `WALL_KEY` for a wall, and its row."""
    pairs = np.empty((hits.shape[0], 3), dtype=np.int64)
    for k in range(hits.shape[0]):
        first = marks[KEY, hits[k, HIT_BODY]]
        second = np.int64(rows.WALL_KEY)
        if hits[k, HIT_WALL] < 0:
            second = marks[KEY, hits[k, HIT_OTHER]]
            if second < first:
                first, second = second, first
        pairs[k, 0] = first
        pairs[k, 1] = second
        pairs[k, 2] = k
    return pairs
