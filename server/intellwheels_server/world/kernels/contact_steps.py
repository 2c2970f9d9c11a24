"""Sub-steps of contact: the members of an island, moved together through a tick, one island after the other.

The named tuples are unpacked once a tick, in `settle`. The phases of a sub-step are functions that are inlined there,
since they run in every sub-step. They take the arrays one by one: numba counts the references to each array of a tuple
whenever it is unpacked, which costs more than some of the phases do.
"""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import (
    BLOCKED,
    COLLIDED,
    END_HEADING,
    END_X,
    END_Y,
    FORWARD,
    HIT_WHO,
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
from intellwheels_server.world.kernels.contact_alone import best_alone
from intellwheels_server.world.kernels.contact_hits import Outcomes, flag_collision, record_hit
from intellwheels_server.world.kernels.contact_islands import (
    ISLAND_MOTION,
    ISLAND_THICKNESS,
    MEMBER_COUNT,
    NEXT_MEMBER,
    Partners,
)
from intellwheels_server.world.kernels.contact_work import (
    FREE,
    GOES_BACK,
    GOT_PROPOSAL,
    IN_CONFLICT,
    STAYS,
    Motions,
    Spots,
    Work,
)
from intellwheels_server.world.kernels.geometry import arc
from intellwheels_server.world.kernels.penetration import (
    OF_KEY,
    OF_NEAR,
    SPOT_C,
    SPOT_H,
    SPOT_RADIUS,
    SPOT_S,
    SPOT_X,
    SPOT_Y,
    beyond_edge,
    copy_spot,
    may_stand,
    set_spot,
    wall_excess,
)

# Longest sub-step, m.
_LONGEST_STEP = 0.02

MOST_STEPS = 1023
"""Largest number of sub-steps in a tick, since lots are drawn by 1024 tick + sub-step.

If it is reached, a sub-step still moves no body farther than half its own thinnest part: a body that is faster is
refused when it joins. So nothing passes through anything, however thin a wall is.
"""

# Wheels stall when the body makes less than this share of the wanted motion.
_STALL_SHARE = 0.02

# The bit of a collision flag that says that the hit of a wall is recorded; cleared at the end of the tick.
_WALL_RECORDED = 2


@njit(cache=True, error_model="numpy")
def lot(key: int, tick: int, step: int) -> int:
    """Return the lot of a body in a sub-step, 64 bits. Of two conflicting results that with the smaller lot goes back.

    Args:
        key: Of the body's name.
        tick: Which tick.
        step: Which sub-step, from 0, below 1024.

    Source:
        Steele, Lea, Flood, Fast splittable pseudorandom number generators, 2014 (SplitMix64).
    """
    count = np.uint64(1024) * np.uint64(tick) + np.uint64(step) + np.uint64(1)
    z = np.uint64(key) + np.uint64(0x9E3779B97F4A7C15) * count
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))  # type: ignore[return-value]


@njit(cache=True, error_model="numpy", inline="always")
def _propose(
    pose: Floats, twist: Floats, old: Floats, ref: Floats, proposal: Floats, status: Ints, members: Ints, step: int,
    steps: int,
) -> None:  # fmt: skip
    """Set the proposals of the members, and let the others see them there.

    A body that was granted everything so far proposes a pose on its arc of the whole tick, so that no rounding adds up.
    """
    for m in range(members.shape[0]):
        i = members[m]
        share = 1.0 / steps
        x, y, h = old[i, SPOT_X], old[i, SPOT_Y], old[i, SPOT_H]
        if status[FREE, i] != 0:
            share = (step + 1) / steps
            x, y, h = pose[rows.X, i], pose[rows.Y, i], pose[rows.HEADING, i]
        x, y, h, c, s = arc(x, y, h, share * twist[TRAVEL, i], share * twist[TURN, i])
        set_spot(proposal, i, x, y, h, c, s)
        set_spot(ref, i, x, y, h, c, s)
        status[STAYS, i] = 0
        status[IN_CONFLICT, i] = 0


@njit(cache=True, error_model="numpy", inline="always")
def _find_wall_conflicts(
    parts: Floats, pieces: Floats, links: Ints, edges: Floats, index: Ints, around: Ints, old: Floats, ref: Floats,
    proposal: Floats, twist: Floats, status: Ints, flags: Ints, hits: Ints, hit_numbers: Floats, members: Ints,
    used: int,
) -> int:  # fmt: skip
    """Mark the proposals that lead into a wall or beyond the edge of the world; return the number of hits so far."""
    for m in range(members.shape[0]):
        i = members[m]
        excess, _, partner = wall_excess(
            parts, pieces, links, edges, index, around, old,
            i, proposal[i, SPOT_X], proposal[i, SPOT_Y], proposal[i, SPOT_C], proposal[i, SPOT_S],
        )  # fmt: skip
        # Sliding and turning away from an obstacle may lead beyond the edge, though the arc did not.
        if beyond_edge(proposal[i, SPOT_X], proposal[i, SPOT_Y]):
            status[IN_CONFLICT, i] = 1
        if excess > 0.0:
            status[IN_CONFLICT, i] = 1
            if flags[COLLIDED, i] & _WALL_RECORDED == 0:
                flags[COLLIDED, i] |= 1 | _WALL_RECORDED
                flags[TOUCHED, i] = 1
                record_hit(
                    parts, pieces, links, edges, index, old, twist, i, proposal, partner, ref,
                    flags[COLLIDED, i] & 1, hits, hit_numbers, used,
                )  # fmt: skip
                used += 1
    return used


@njit(cache=True, error_model="numpy", inline="always")
def _find_who_stays(
    parts: Floats, pieces: Floats, links: Ints, edges: Floats, index: Ints, around: Ints, old: Floats, ref: Floats,
    proposal: Floats, pair_of: Ints, pair_hit: Ints, twist: Floats, status: Ints, queue: Ints, flags: Ints, hits: Ints,
    hit_numbers: Floats, members: Ints, used: int,
) -> tuple[int, int]:  # fmt: skip
    """Queue the members whose proposals are not allowed; return their number and the number of hits so far.

    In the first round each member is tested against its partners at their proposals. A body that is found is then seen
    at its old pose. In each further round the bodies found last are tested against those not found yet.
    """
    first = queued = looked = 0
    while True:
        count = members.shape[0] if looked == 0 else queued
        for q in range(first, count):
            j = members[q] if looked == 0 else queue[q]
            for k in range(index[j, OF_NEAR], index[j + 1, OF_NEAR]):
                i = around[k]
                mover, other = (j, i) if looked == 0 else (i, j)
                mutual = status[STAYS, other] == 0
                if status[STAYS, mover] != 0 or (mutual and other < mover):
                    continue
                if may_stand(parts, index, old, proposal, mover, ref, other):
                    continue
                status[IN_CONFLICT, mover] = 1
                if mutual:
                    status[IN_CONFLICT, other] = 1
                who = flag_collision(parts, index, old, proposal, mover, other, mutual, flags)
                if who == 0:
                    continue
                known = pair_hit[pair_of[k]]
                # In a hit the lower index comes first.
                low, high, low_at, high_at = mover, other, proposal, ref
                if low > high:
                    low, high, low_at, high_at = other, mover, ref, proposal
                    who = ((who & 1) << 1) | (who >> 1)
                if known >= 0:
                    if known < hits.shape[0]:
                        hits[known, HIT_WHO] |= who
                    continue
                pair_hit[pair_of[k]] = used
                record_hit(
                    parts, pieces, links, edges, index, old, twist, low, low_at, high, high_at,
                    who, hits, hit_numbers, used,
                )  # fmt: skip
                used += 1
        looked += 1
        first = queued
        for m in range(members.shape[0]):
            i = members[m]
            if status[IN_CONFLICT, i] != 0 and status[STAYS, i] == 0:
                status[STAYS, i] = 1
                copy_spot(ref, old, i)
                queue[queued] = i
                queued += 1
        if first == queued:
            break
    return queued, used


@njit(cache=True, error_model="numpy", inline="always")
def _find_results(
    parts: Floats, pieces: Floats, links: Ints, edges: Floats, index: Ints, around: Ints, old: Floats, ref: Floats,
    proposal: Floats, result: Floats, twist: Floats, motion: Floats, status: Ints, gain: Floats, queue: Ints,
    queued: int, steps: int,
) -> None:  # fmt: skip
    """Find the best pose of each body that stays."""
    for q in range(queued):
        i = queue[q]
        taken, gain[0, i], gain[1, i] = best_alone(
            parts, pieces, links, edges, index, around, old, ref, i, proposal,
            twist[TRAVEL, i] / steps, twist[TURN, i] / steps, motion[i] / steps, result,
        )  # fmt: skip
        status[GOT_PROPOSAL, i] = 1 if taken else 0
        status[GOES_BACK, i] = 0


@njit(cache=True, error_model="numpy", inline="always")
def _send_back(
    parts: Floats, index: Ints, around: Ints, old: Floats, result: Floats, status: Ints, queue: Ints, queued: int,
    tick: int, step: int,
) -> None:  # fmt: skip
    """Of two bodies whose results conflict, mark the one with the smaller lot to go back."""
    for q in range(queued):
        i = queue[q]
        for k in range(index[i, OF_NEAR], index[i + 1, OF_NEAR]):
            j = around[k]
            if j < i or status[IN_CONFLICT, j] == 0 or may_stand(parts, index, old, result, i, result, j):
                continue
            lot_i, lot_j = lot(index[i, OF_KEY], tick, step), lot(index[j, OF_KEY], tick, step)
            i_back = lot_i < lot_j or (lot_i == lot_j and index[i, OF_KEY] > index[j, OF_KEY])
            status[GOES_BACK, i if i_back else j] = 1


@njit(cache=True, error_model="numpy", inline="always")
def _move(
    twist: Floats, old: Floats, proposal: Floats, result: Floats, status: Ints, gain: Floats, outcome: Floats,
    members: Ints, steps: int,
) -> None:  # fmt: skip
    """Move the members to their poses after the sub-step."""
    for m in range(members.shape[0]):
        i = members[m]
        if status[STAYS, i] == 0:
            copy_spot(old, proposal, i)
            outcome[FORWARD, i] += twist[TRAVEL, i] / steps
            outcome[TURNED, i] += twist[TURN, i] / steps
        elif status[GOES_BACK, i] == 0:
            copy_spot(old, result, i)
            outcome[FORWARD, i] += gain[0, i]
            outcome[TURNED, i] += gain[1, i]
            status[FREE, i] &= status[GOT_PROPOSAL, i]
        else:
            status[FREE, i] = 0


@njit(cache=True, error_model="numpy", inline="always")
def _conclude(
    pose: Floats, twist: Floats, motion: Floats, old: Floats, status: Ints, outcome: Floats, flags: Ints, members: Ints
) -> None:
    """Write the poses of the members after the tick, and which of them were blocked or stalled."""
    for m in range(members.shape[0]):
        i = members[m]
        outcome[END_X, i], outcome[END_Y, i] = old[i, SPOT_X], old[i, SPOT_Y]
        outcome[END_HEADING, i] = old[i, SPOT_H]
        flags[COLLIDED, i] &= 1
        if status[FREE, i] != 0:
            outcome[FORWARD, i], outcome[TURNED, i] = twist[TRAVEL, i], twist[TURN, i]
            continue
        flags[BLOCKED, i] = 1
        dx, dy = outcome[END_X, i] - pose[rows.X, i], outcome[END_Y, i] - pose[rows.Y, i]
        achieved = np.sqrt(dx * dx + dy * dy) + abs(outcome[TURNED, i]) * old[i, SPOT_RADIUS]
        if achieved < _STALL_SHARE * motion[i]:
            flags[STALLED, i] = 1


@njit(cache=True, error_model="numpy", inline="always")
def settle(
    bodies: Bodies, walls: Walls, partners: Partners, motions: Motions, spots: Spots, work: Work, outcomes: Outcomes,
    island: Floats, listed: Ints, tick: int, used: int,
) -> int:  # fmt: skip
    """Move the members of all tight islands through their sub-steps; return the number of hits so far.

    Args:
        bodies: Their shapes.
        walls: The walls.
        partners: The partners of each body; `pair_hit` is written.
        motions: The motions that the bodies want.
        spots: The poses; written for the members.
        work: Written for the members.
        outcomes: Written for the members.
        island: float64[3, n], an island block.
        listed: int64[3, n], their members, a member list.
        tick: The tick, from which the lots are drawn.
        used: The number of hits so far.
    """
    parts, (pieces, links, edges, _, _), (index, around, pair_of, pair_hit) = bodies.parts, walls, partners
    (pose, twist, motion), (old, ref, proposal, result), (status, gain, queue) = motions, spots, work
    outcome, flags, hits, hit_numbers = outcomes
    room = np.empty(listed.shape[1], dtype=np.int64)
    for root in range(listed.shape[1]):
        count = listed[MEMBER_COUNT, root]
        if count == 0:
            continue
        i = root
        for k in range(count):
            room[k] = i
            status[FREE, i] = 1
            i = listed[NEXT_MEMBER, i]
        members = room[:count]
        wanted = np.ceil(island[ISLAND_MOTION, root] / min(_LONGEST_STEP, 0.5 * island[ISLAND_THICKNESS, root]))
        steps = int(min(wanted, float(MOST_STEPS)))
        for step in range(steps):
            _propose(pose, twist, old, ref, proposal, status, members, step, steps)
            used = _find_wall_conflicts(
                parts, pieces, links, edges, index, around, old, ref, proposal, twist, status, flags, hits, hit_numbers,
                members, used,
            )  # fmt: skip
            queued, used = _find_who_stays(
                parts, pieces, links, edges, index, around, old, ref, proposal, pair_of, pair_hit, twist, status, queue,
                flags, hits, hit_numbers, members, used,
            )  # fmt: skip
            _find_results(
                parts, pieces, links, edges, index, around, old, ref, proposal, result, twist, motion, status, gain,
                queue, queued, steps,
            )  # fmt: skip
            _send_back(parts, index, around, old, result, status, queue, queued, tick, step)
            _move(twist, old, proposal, result, status, gain, outcome, members, steps)
        _conclude(pose, twist, motion, old, status, outcome, flags, members)
    return used
