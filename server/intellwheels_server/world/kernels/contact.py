"""Contact: how bodies move when something is in the way of the arcs that they want to drive.

Rule:
    Bodies never push each other. A tick is cut into sub-steps, and in each of them all bodies propose a pose on their
    arc. Bodies whose proposals are not allowed are found together: they stay. Each of them then finds the best motion
    that is possible while all others keep their poses: it slides along the obstacle, goes straight, turns, or drives
    a share of its arc. The order of bodies in the arrays has no influence: every decision is a maximum, a minimum or
    an "any", and ties are broken by the index of the wall piece and by the key of the name.

Symbols:
    d, a    travel along the arc, m, and turn, rad, that a body wants in the tick
    r       distance of its farthest corner from its centre of movement, m
    m       |d| + |a| r: no point of the body moves farther in the tick
    partner a thing that a body could meet: a body whose circle of r + |d| + m meets its own, or a wall piece in it
    island  movers that are connected by partnership; islands do not influence each other
    tight   an island in which circles of r + |d| meet, so that a proposal can meet something

    A pose is allowed if against every partner the depth is at most the depth at the start of the sub-step, or the
    allowed penetration of a body that was put into something, or `penetration.TOLERANCE`.

Why it terminates, and why the result is allowed:
    1. A tick has at most `contact_steps.MOST_STEPS` sub-steps. A sub-step moves no body farther than half the thinnest
       thing in the island or, with that many sub-steps, half its own thinnest part. So nothing passes through anything.
    2. The bodies that stay are found in rounds. They stay for the rest of the sub-step, and every round but the last
       finds at least one more. So there is at most one round more than members.
    3. Finding the best motion takes 4 attempts and 12 bisections, each with at most 8 pushes out. The pose at the start
       of the sub-step is always allowed, so there is always an answer.
    4. After the rounds, the granted proposals are allowed against one another and against the bodies that stay, as long
       as these keep their old poses. Each result of a body that stays is allowed against the granted proposals and
       against the old poses of the others that stay. Two results may conflict; then one of the two bodies returns to
       its old pose, which is allowed against all others. So one pass over the results is enough.
"""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.allowed_penetration import deepest_overlap
from intellwheels_server.world.kernels.arrays import (
    END_ALLOWED,
    END_HEADING,
    END_X,
    END_Y,
    FORWARD,
    TRAVEL,
    TURN,
    TURNED,
    Bodies,
    Floats,
    Ints,
    Walls,
)
from intellwheels_server.world.kernels.contact_hits import Outcomes
from intellwheels_server.world.kernels.contact_islands import (
    ISLAND_TIGHT,
    REACH_MOTION,
    Neighbours,
    find_islands,
    list_members,
    neighbours_of,
    partners_of,
    reaches,
)
from intellwheels_server.world.kernels.contact_steps import settle
from intellwheels_server.world.kernels.contact_work import STATUS_ROWS, STAYS, Motions, Spots, Work
from intellwheels_server.world.kernels.geometry import arc
from intellwheels_server.world.kernels.penetration import TOLERANCE, spots_of


@njit(cache=True, error_model="numpy", inline="always")
def _stand_still(pose: Floats, allowed: Floats, outcome: Floats, flags: Ints) -> None:
    """Write the outcome of bodies that do not move."""
    for i in range(pose.shape[1]):
        outcome[END_X, i], outcome[END_Y, i] = pose[rows.X, i], pose[rows.Y, i]
        outcome[END_HEADING, i] = pose[rows.HEADING, i]
        outcome[FORWARD, i] = outcome[TURNED, i] = 0.0
        outcome[END_ALLOWED, i] = allowed[i]
        for k in range(4):
            flags[k, i] = 0


@njit(cache=True, error_model="numpy", inline="always")
def _grant_all(pose: Floats, twist: Floats, motion: Floats, parent: Ints, island: Floats, outcome: Floats) -> None:
    """Write the outcome of movers in islands that are not tight: their proposals are granted."""
    for i in range(pose.shape[1]):
        if motion[i] > 0.0 and island[ISLAND_TIGHT, parent[i]] == 0.0:
            d, a = twist[TRAVEL, i], twist[TURN, i]
            x, y, h, _, _ = arc(pose[rows.X, i], pose[rows.Y, i], pose[rows.HEADING, i], d, a)
            outcome[END_X, i], outcome[END_Y, i], outcome[END_HEADING, i] = x, y, h
            outcome[FORWARD, i], outcome[TURNED, i] = d, a


@njit(cache=True, error_model="numpy", inline="always")
def _settle_all(
    bodies: Bodies, walls: Walls, neighbours: Neighbours, motions: Motions, reach: Floats, allowed: Floats,
    parent: Ints, island: Floats, tick: int, outcomes: Outcomes, used: int,
) -> int:  # fmt: skip
    """Settle the tight islands; return how many hits there are now."""
    n = parent.shape[0]
    partners = partners_of(bodies.part_start, bodies.marks, neighbours)
    old = spots_of(motions.pose, bodies.shape, allowed)
    spots = Spots(old, old.copy(), np.empty((n, 5)), np.empty((n, 5)))
    work = Work(np.zeros((STATUS_ROWS, n), dtype=np.int64), np.empty((2, n)), np.empty(n, dtype=np.int64))
    listed = list_members(reach, parent, island)
    # A body that does not move stays in every sub-step. For members of an island this is set in each sub-step.
    for i in range(n):
        work.status[STAYS, i] = 1
    return settle(bodies, walls, partners, motions, spots, work, outcomes, island, listed, tick, used)


@njit(cache=True, error_model="numpy")
def resolve(
    bodies: Bodies, walls: Walls, pose: Floats, twist: Floats, allowed: Floats, tick: int, outcomes: Outcomes
) -> int:
    """Move all bodies by one tick; only the outcomes are written.

    Args:
        bodies: Their shapes. An externally posed body does not move, even if its twist is not 0.
        walls: The walls.
        pose: float64[3, n].
        twist: float64[2, n], m and rad.
        allowed: float64[n], allowed penetration, m.
        tick: The tick, from which the lots are drawn.
        outcomes: Out.

    Returns:
        The number of hits. If there is not room for all of them, call again with more room.
    """
    n = pose.shape[1]
    _stand_still(pose, allowed, outcomes.outcome, outcomes.flags)
    reach = reaches(bodies.shape, bodies.marks, twist)
    moves = overlap_allowed = False
    for i in range(n):
        moves |= reach[REACH_MOTION, i] > 0.0
        overlap_allowed |= allowed[i] > 0.0
    # To numba a plain 0 has another type, and it would compile the functions that take it twice.
    used = outcomes.hits.shape[0] - outcomes.hits.shape[0]
    if moves:
        neighbours = neighbours_of(bodies.shape, walls.pieces, walls.cells, walls.frame, pose, reach)
        parent = np.empty(n, dtype=np.int64)
        island = np.empty((3, n))
        any_tight = find_islands(bodies.shape, walls.pieces, pose, reach, neighbours, parent, island)
        motion = reach[REACH_MOTION]
        _grant_all(pose, twist, motion, parent, island, outcomes.outcome)
        if any_tight:
            motions = Motions(pose, twist, motion)
            used = _settle_all(bodies, walls, neighbours, motions, reach, allowed, parent, island, tick, outcomes, used)
    if overlap_allowed:
        outcome = outcomes.outcome
        for i in range(n):
            if allowed[i] > 0.0 and deepest_overlap(bodies, walls, outcome, i) <= TOLERANCE:
                outcome[END_ALLOWED, i] = 0.0
    return int(used)
