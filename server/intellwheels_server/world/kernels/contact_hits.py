"""Hits: the pairs that met in a tick, and which of the two ran into the other."""

from typing import NamedTuple

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import (
    COLLIDED,
    HIT_BODY,
    HIT_CLOSING,
    HIT_DEPTH,
    HIT_NORMAL_X,
    HIT_NORMAL_Y,
    HIT_OTHER,
    HIT_OTHER_PART,
    HIT_PART,
    HIT_WALL,
    HIT_WHO,
    HIT_X,
    HIT_Y,
    TOUCHED,
    TRAVEL,
    TURN,
    WALL,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.penetration import (
    A_WALL,
    SPOT_C,
    SPOT_S,
    SPOT_X,
    SPOT_Y,
    TOLERANCE,
    contact_of,
    spot_depth,
)


class Outcomes(NamedTuple):
    """The arrays that a tick of contact writes.

    Attributes:
        outcome: float64[6, n], rows `END_X` to `END_ALLOWED` of `arrays`.
        flags: int64[4, n], rows `BLOCKED` to `TOUCHED`.
        hits: int64[room, 6], columns `HIT_BODY` to `HIT_WHO`; each pair once per tick, in any order.
        hit_numbers: float64[room, 6], columns `HIT_X` to `HIT_CLOSING`.
    """

    outcome: Floats
    flags: Ints
    hits: Ints
    hit_numbers: Floats


@njit(cache=True, error_model="numpy")
def record_hit(
    parts: Floats, pieces: Floats, links: Ints, edges: Floats, index: Ints, old: Floats, twist: Floats,
    i: int, at: Floats, partner: int, others_at: Floats, who: int, hits: Ints, hit_numbers: Floats, used: int,
) -> None:  # fmt: skip
    """Record as hit number `used` that body i met a partner, if there is room."""
    if used >= hits.shape[0]:
        return
    depth, nx, ny, part, other_part, px, py = contact_of(
        parts, pieces, links, edges, index, others_at,
        i, at[i, SPOT_X], at[i, SPOT_Y], at[i, SPOT_C], at[i, SPOT_S], partner,
    )  # fmt: skip
    speed_x = twist[TRAVEL, i] * old[i, SPOT_C] - twist[TURN, i] * (py - old[i, SPOT_Y])
    speed_y = twist[TRAVEL, i] * old[i, SPOT_S] + twist[TURN, i] * (px - old[i, SPOT_X])
    wall = -1
    if partner >= 0:
        speed_x -= twist[TRAVEL, partner] * old[partner, SPOT_C] - twist[TURN, partner] * (py - old[partner, SPOT_Y])
        speed_y -= twist[TRAVEL, partner] * old[partner, SPOT_S] + twist[TURN, partner] * (px - old[partner, SPOT_X])
    else:
        other_part = A_WALL - partner
        wall = links[other_part, WALL]
    hits[used, HIT_BODY], hits[used, HIT_OTHER], hits[used, HIT_WALL] = i, max(partner, A_WALL), wall
    hits[used, HIT_PART], hits[used, HIT_OTHER_PART], hits[used, HIT_WHO] = part, other_part, who
    hit_numbers[used, HIT_X], hit_numbers[used, HIT_Y] = px, py
    hit_numbers[used, HIT_NORMAL_X], hit_numbers[used, HIT_NORMAL_Y] = nx, ny
    hit_numbers[used, HIT_DEPTH], hit_numbers[used, HIT_CLOSING] = depth, -(speed_x * nx + speed_y * ny)


@njit(cache=True, error_model="numpy")
def flag_collision(
    parts: Floats, index: Ints, old: Floats, proposal: Floats, i: int, j: int, mutual: bool, flags: Ints
) -> int:
    """Flag which bodies of a pair in conflict collide; return 1 if i does, plus 2 if j does.

    A body collides if its own proposal alone brings it deeper into the other, or nearer to it.
    """
    was = spot_depth(parts, index, old, i, old, j, -np.inf)
    who = 0
    for side in range(2 if mutual else 1):
        a, b = (i, j) if side == 0 else (j, i)
        if spot_depth(parts, index, proposal, a, old, b, -np.inf) > was + TOLERANCE:
            flags[COLLIDED, a] |= 1
            who |= 1 << side
    if who != 0:
        flags[TOUCHED, i] = 1
        flags[TOUCHED, j] = 1
    return who
