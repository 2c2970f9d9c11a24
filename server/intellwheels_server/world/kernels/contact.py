"""Contact: what becomes of the arcs that bodies want to drive when something is in the way.

Nobody pushes anybody. All bodies propose, those whose proposals may not stand are found together, and each of them
then looks for the best it can do alone. Nothing here depends on the order of bodies in the arrays: every
decision is a largest, a least or an any, with ties broken by wall index and key.

Words: m = |travel| + |turn| r bounds how far any point of a body moves in the tick, r being its farthest corner. A
partner is what a body could meet: circles of r + |travel| + m meet. An island is a set of movers connected by
partnership. `FREE` is who still got every proposal of the tick; `STAY` who does not get the present one.
"""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import (
    ANCHORED,
    BLOCKED,
    COLLISION,
    CONTACT,
    END_HEADING,
    END_X,
    END_Y,
    FORWARD,
    HEADING,
    HELD,
    HIGHEST,
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
    KEY,
    LICENCE,
    LOWEST,
    PIECE_THICKNESS,
    RADIUS,
    STALLED,
    THICKNESS,
    TRAVEL,
    TURN,
    TURNED,
    WALL,
    Floats,
    Ints,
    X,
    Y,
)
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.geometry import arc, body_depth
from intellwheels_server.world.kernels.neighbours import pairs_near, piece_apart, pieces_near
from intellwheels_server.world.kernels.standing import (
    A_WALL,
    OF_ANCHORED,
    OF_KEY,
    OF_NEAR,
    OF_PARTS,
    OF_WALLS,
    SPOT_C,
    SPOT_H,
    SPOT_RADIUS,
    SPOT_S,
    SPOT_X,
    SPOT_Y,
    TOLERANCE,
    beyond_edge,
    contact_of,
    copy_spot,
    deepest_piece,
    may_stand,
    set_spot,
    slide,
    spot_depth,
    spots_of,
    wall_excess,
)

# Longest sub-step, m.
_LONGEST_STEP = 0.02
# Sub-steps a tick at most, since lots are drawn by 1024 tick + sub-step. Reached by no body of sane size: at 3 m/s and
# 20 Hz it would need parts of 0.3 mm.
_MOST_STEPS = 1023

_HALVINGS = 12

# Wheels stall when less than this share of the wanted motion came about.
_STALL_SHARE = 0.02

# Columns of the reach block, float64[3, n]: m; r + |travel| + m; r + |travel|.
_MOTION, _WIDE, _SURE = 0, 1, 2

# Rows of a status, int64[5, n]: still got every proposal of the tick; has no proposal in this sub-step; is in
# the queue of those; got its proposal after all; goes back, since another's result conflicts.
_FREE, _STAY, _NOTED, _GOT, _BACK = 0, 1, 2, 3, 4
# The bit of a collision flag that says that the wall was written down; taken off at the end.
_WALL_KNOWN = 2


@njit(cache=True, error_model="numpy")
def _alone(
    parts: Floats, pieces: Floats, links: Ints, edges: Floats, index: Ints, around: Ints, old: Floats, ref: Floats,
    i: int, proposal: Floats, travel: float, turn: float, most: float, result: Floats,
) -> tuple[bool, float, float]:  # fmt: skip
    """Find the best body i can do in this sub-step with all others where they are, and put it in `result`.

    Args:
        parts: As in `standing`, as the next seven.
        pieces: As in `standing`.
        links: As in `standing`.
        edges: As in `standing`.
        index: As in `standing`.
        around: As in `standing`.
        old: As in `standing`.
        ref: As in `standing`.
        i: The body.
        proposal: Spots proposed.
        travel: Of the sub-step, m.
        turn: Of the sub-step, rad.
        most: m of the sub-step, the farthest it may be moved out.
        result: Spots, out.

    Returns:
        Whether it gets its proposal to the bit; forward travel, m, and turn, rad, achieved.
    """
    copy_spot(result, old, i)
    low, high = 0.0, 1.0
    for attempt in range(4 + _HALVINGS):
        share, d, a, allowed = 1.0, travel, turn, 0.0
        if attempt == 1:
            allowed = most
        elif attempt == 2:
            a, allowed = 0.0, abs(travel)
        elif attempt == 3:
            d = 0.0
        elif attempt > 3:
            share = 0.5 * (low + high)
            d, a = share * travel, share * turn
        # What is hinged does not slide. To go straight without travel, or to turn without turn, is to stand still.
        if 0 < attempt <= 3 and (index[i, OF_ANCHORED] != 0 or (d == 0.0 and a == 0.0)):
            continue
        if attempt == 0:
            x, y, h = proposal[i, SPOT_X], proposal[i, SPOT_Y], proposal[i, SPOT_H]
            c, s = proposal[i, SPOT_C], proposal[i, SPOT_S]
        else:
            x, y, h, c, s = arc(old[i, SPOT_X], old[i, SPOT_Y], old[i, SPOT_H], d, a)
        found, px, py = slide(parts, pieces, links, edges, index, around, old, ref, i, x, y, c, s, allowed)
        if found:
            low = share
            set_spot(result, i, px, py, h, c, s)
            if attempt <= 3:
                return attempt == 0, d + ((px - x) * c + (py - y) * s), a
        elif attempt > 3:
            high = share
    return False, low * travel, low * turn


@njit(cache=True, error_model="numpy")
def lot(key: int, tick: int, step: int) -> int:
    """Return a body's turn in a sub-step, 64 bits: of two whose ways conflict, the smaller goes back.

    Args:
        key: Of the body's name.
        tick: Which tick.
        step: Which sub-step, from 0.

    Source:
        Steele, Lea, Flood, Fast splittable pseudorandom number generators, 2014 (SplitMix64).
    """
    count = np.uint64(1024) * np.uint64(tick) + np.uint64(step) + np.uint64(1)
    z = np.uint64(key) + np.uint64(0x9E3779B97F4A7C15) * count
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))  # type: ignore[return-value]


@njit(cache=True, error_model="numpy")
def _put_down(
    parts: Floats, pieces: Floats, links: Ints, edges: Floats, index: Ints, old: Floats, twist: Floats,
    i: int, at: Floats, partner: int, others_at: Floats, who: int, hits: Ints, hit_numbers: Floats, used: int,
) -> None:  # fmt: skip
    """Write down as hit number `used` that i met a partner, if there is room."""
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
def _collided(
    parts: Floats, index: Ints, old: Floats, proposal: Floats, i: int, j: int, mutual: bool, flags: Ints
) -> int:
    """Flag who of a pair that may not stand collides; return 1 if i does, plus 2 if j does.

    Who comes deeper into the other, or nearer to it, by its own proposal alone, collides.
    """
    was = spot_depth(parts, index, old, i, old, j, -np.inf)
    who = 0
    for side in range(2 if mutual else 1):
        a, b = (i, j) if side == 0 else (j, i)
        if spot_depth(parts, index, proposal, a, old, b, -np.inf) > was + TOLERANCE:
            flags[COLLISION, a] |= 1
            who |= 1 << side
    if who != 0:
        flags[CONTACT, i] = 1
        flags[CONTACT, j] = 1
    return who


@njit(cache=True, error_model="numpy")
def _settle(
    parts: Floats, pieces: Floats, links: Ints, edges: Floats, index: Ints, around: Ints, old: Floats, ref: Floats,
    proposal: Floats, result: Floats, status: Ints, gain: Floats, queue: Ints, members: Ints, steps: int, tick: int,
    pose: Floats, twist: Floats, motion: Floats, outcome: Floats, flags: Ints, hits: Ints, hit_numbers: Floats,
    edge: Ints, edge_hit: Ints, used: int,
) -> int:  # fmt: skip
    """Move the members of one island through their sub-steps; return how many hits there are now.

    `gain` has rows: forward travel and turn of a sub-step. `edge` numbers the pairs of `around`; `edge_hit` has the hit
    of each, or -1.
    """
    for m in range(members.shape[0]):
        status[_FREE, members[m]] = 1
    for step in range(steps):
        for m in range(members.shape[0]):
            i = members[m]
            share = 1.0 / steps
            x, y, h = old[i, SPOT_X], old[i, SPOT_Y], old[i, SPOT_H]
            if status[_FREE, i] != 0:
                share = (step + 1) / steps
                x, y, h = pose[X, i], pose[Y, i], pose[HEADING, i]
            x, y, h, c, s = arc(x, y, h, share * twist[TRAVEL, i], share * twist[TURN, i])
            set_spot(proposal, i, x, y, h, c, s)
            set_spot(ref, i, x, y, h, c, s)
            status[_STAY, i] = 0
            status[_NOTED, i] = 0
        # Who has to stay: in the first round everybody is at proposals, then those found are seen where they were.
        first = queued = 0
        for m in range(members.shape[0]):
            i = members[m]
            excess, _, partner = wall_excess(
                parts, pieces, links, edges, index, around, old,
                i, proposal[i, SPOT_X], proposal[i, SPOT_Y], proposal[i, SPOT_C], proposal[i, SPOT_S],
            )  # fmt: skip
            # Sliding and turning away from what is in the way may lead beyond the edge, though the arc did not.
            if beyond_edge(proposal[i, SPOT_X], proposal[i, SPOT_Y]):
                status[_NOTED, i] = 1
            if excess > 0.0:
                status[_NOTED, i] = 1
                if flags[COLLISION, i] & _WALL_KNOWN == 0:
                    flags[COLLISION, i] |= 1 | _WALL_KNOWN
                    flags[CONTACT, i] = 1
                    _put_down(
                        parts, pieces, links, edges, index, old, twist, i, proposal, partner, ref,
                        flags[COLLISION, i] & 1, hits, hit_numbers, used,
                    )  # fmt: skip
                    used += 1
        looked = 0
        while True:
            # In the first round from each member to its partners, later from each who stays to those who do not.
            count = members.shape[0] if looked == 0 else queued
            for q in range(first, count):
                j = members[q] if looked == 0 else queue[q]
                for k in range(index[j, OF_NEAR], index[j + 1, OF_NEAR]):
                    i = around[k]
                    mover, other = (j, i) if looked == 0 else (i, j)
                    mutual = status[_STAY, other] == 0
                    if status[_STAY, mover] != 0 or (mutual and other < mover):
                        continue
                    if may_stand(parts, index, old, proposal, mover, ref, other):
                        continue
                    status[_NOTED, mover] = 1
                    if mutual:
                        status[_NOTED, other] = 1
                    who = _collided(parts, index, old, proposal, mover, other, mutual, flags)
                    if who == 0:
                        continue
                    known = edge_hit[edge[k]]
                    # In a hit the lower index comes first.
                    low, high, low_at, high_at = mover, other, proposal, ref
                    if low > high:
                        low, high, low_at, high_at = other, mover, ref, proposal
                        who = ((who & 1) << 1) | (who >> 1)
                    if known >= 0:
                        if known < hits.shape[0]:
                            hits[known, HIT_WHO] |= who
                        continue
                    edge_hit[edge[k]] = used
                    _put_down(
                        parts, pieces, links, edges, index, old, twist, low, low_at, high, high_at,
                        who, hits, hit_numbers, used,
                    )  # fmt: skip
                    used += 1
            looked += 1
            first = queued
            for m in range(members.shape[0]):
                i = members[m]
                if status[_NOTED, i] != 0 and status[_STAY, i] == 0:
                    status[_STAY, i] = 1
                    copy_spot(ref, old, i)
                    queue[queued] = i
                    queued += 1
            if first == queued:
                break
        for q in range(queued):
            i = queue[q]
            taken, gain[0, i], gain[1, i] = _alone(
                parts, pieces, links, edges, index, around, old, ref, i, proposal,
                twist[TRAVEL, i] / steps, twist[TURN, i] / steps, motion[i] / steps, result,
            )  # fmt: skip
            status[_GOT, i] = 1 if taken else 0
            status[_BACK, i] = 0
        for q in range(queued):
            i = queue[q]
            for k in range(index[i, OF_NEAR], index[i + 1, OF_NEAR]):
                j = around[k]
                if j < i or status[_NOTED, j] == 0 or may_stand(parts, index, old, result, i, result, j):
                    continue
                lot_i, lot_j = lot(index[i, OF_KEY], tick, step), lot(index[j, OF_KEY], tick, step)
                i_back = lot_i < lot_j or (lot_i == lot_j and index[i, OF_KEY] > index[j, OF_KEY])
                status[_BACK, i if i_back else j] = 1
        for m in range(members.shape[0]):
            i = members[m]
            if status[_STAY, i] == 0:
                copy_spot(old, proposal, i)
                outcome[FORWARD, i] += twist[TRAVEL, i] / steps
                outcome[TURNED, i] += twist[TURN, i] / steps
            elif status[_BACK, i] == 0:
                copy_spot(old, result, i)
                outcome[FORWARD, i] += gain[0, i]
                outcome[TURNED, i] += gain[1, i]
                status[_FREE, i] &= status[_GOT, i]
            else:
                status[_FREE, i] = 0
    for m in range(members.shape[0]):
        i = members[m]
        outcome[END_X, i], outcome[END_Y, i] = old[i, SPOT_X], old[i, SPOT_Y]
        outcome[END_HEADING, i] = old[i, SPOT_H]
        flags[COLLISION, i] &= 1
        if status[_FREE, i] != 0:
            outcome[FORWARD, i], outcome[TURNED, i] = twist[TRAVEL, i], twist[TURN, i]
            continue
        flags[BLOCKED, i] = 1
        dx, dy = outcome[END_X, i] - pose[X, i], outcome[END_Y, i] - pose[Y, i]
        achieved = np.sqrt(dx * dx + dy * dy) + abs(outcome[TURNED, i]) * old[i, SPOT_RADIUS]
        if achieved < _STALL_SHARE * motion[i]:
            flags[STALLED, i] = 1
    return used


@njit(cache=True, error_model="numpy")
def _root(parent: Ints, i: int) -> int:
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@njit(cache=True, error_model="numpy")
def _islands(
    shape: Floats,
    pieces: Floats,
    pose: Floats,
    reach: Floats,
    pairs: Ints,
    wall_start: Ints,
    walls: Ints,
    parent: Ints,
    island: Floats,
) -> bool:
    """Fill in the islands; return whether any has to be settled.

    Args:
        shape: Of the bodies.
        pieces: Of the walls.
        pose: float64[3, n].
        reach: float64[3, n].
        pairs: Partners, of `pairs_near`.
        wall_start: int64[n + 1].
        walls: Wall pieces of each body.
        parent: int64[n], out: the least index of its island, for a mover.
        island: float64[3, n], out, at that index: 1 if proposals can meet anything at all; its largest m; the
            thinnest of its members and partners.
    """
    n = pose.shape[1]
    for i in range(n):
        parent[i] = i
        island[0, i] = 0.0
        island[1, i] = 0.0
        island[2, i] = np.inf
    for e in range(1, pairs[0], 2):
        i, j = pairs[e], pairs[e + 1]
        if reach[_MOTION, i] > 0.0 and reach[_MOTION, j] > 0.0:
            i, j = _root(parent, i), _root(parent, j)
            parent[max(i, j)] = min(i, j)
    any_tight = False
    for i in range(n):
        if reach[_MOTION, i] <= 0.0:
            continue
        root = _root(parent, i)
        parent[i] = root
        island[1, root] = max(island[1, root], reach[_MOTION, i])
        island[2, root] = min(island[2, root], shape[THICKNESS, i])
        for k in range(wall_start[i], wall_start[i + 1]):
            island[2, root] = min(island[2, root], pieces[walls[k], PIECE_THICKNESS])
            if not piece_apart(pieces, walls[k], pose[X, i], pose[Y, i], reach[_SURE, i]):
                island[0, root] = 1.0
                any_tight = True
    for e in range(1, pairs[0], 2):
        i, j = pairs[e], pairs[e + 1]
        root = parent[i] if reach[_MOTION, i] > 0.0 else parent[j]
        island[2, root] = min(island[2, root], shape[THICKNESS, i], shape[THICKNESS, j])
        dx, dy = pose[X, j] - pose[X, i], pose[Y, j] - pose[Y, i]
        both = reach[_SURE, i] + reach[_SURE, j]
        if dx * dx + dy * dy <= both * both:
            island[0, root] = 1.0
            any_tight = True
    return any_tight


@njit(cache=True, error_model="numpy")
def resolve(
    parts: Floats,
    part_start: Ints,
    shape: Floats,
    marks: Ints,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
    pose: Floats,
    twist: Floats,
    licence: Floats,
    tick: int,
    outcome: Floats,
    flags: Ints,
    hits: Ints,
    hit_numbers: Floats,
) -> int:
    """Move all bodies by one tick; nothing but the last four arguments is written to.

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
        pose: float64[3, n].
        twist: float64[2, n]; what is held by marks does not move, whatever its twist.
        licence: float64[n], depth up to which a body that was put into something may be in it, m.
        tick: Which tick: it draws lots.
        outcome: float64[6, n], out, rows `END_X` to `LICENCE`.
        flags: int64[4, n], out, rows `BLOCKED` to `CONTACT`.
        hits: int64[room, 6], out, columns `HIT_BODY` to `HIT_WHO`; each pair once a tick, in no order.
        hit_numbers: float64[room, 6], out, columns `HIT_X` to `HIT_CLOSING`.

    Returns:
        How many hits there are. If that is more than there is room for, call again with more.
    """
    n = pose.shape[1]
    reach = np.empty((3, n))
    moves = licensed = False
    for i in range(n):
        d, a = abs(twist[TRAVEL, i]), abs(twist[TURN, i])
        if marks[HELD, i] != 0:
            d = a = 0.0
        reach[_MOTION, i] = d + a * shape[RADIUS, i]
        reach[_WIDE, i] = shape[RADIUS, i] + d + reach[_MOTION, i]
        reach[_SURE, i] = shape[RADIUS, i] + d
        moves |= reach[_MOTION, i] > 0.0
        licensed |= licence[i] > 0.0
        outcome[END_X, i], outcome[END_Y, i], outcome[END_HEADING, i] = pose[X, i], pose[Y, i], pose[HEADING, i]
        outcome[FORWARD, i] = outcome[TURNED, i] = 0.0
        outcome[LICENCE, i] = licence[i]
        for k in range(4):
            flags[k, i] = 0
    # A plain 0 is a type of its own to numba, which would then compile what takes it twice.
    used = hits.shape[0] - hits.shape[0]
    if moves:
        motion = reach[_MOTION]
        pairs = pairs_near(shape, pose, motion, reach[_WIDE])
        wall_start = np.empty(n + 1, dtype=np.int64)
        walls = np.empty(2 + 8 * n, dtype=np.int64)
        walls[0] = walls[1] = 2
        for i in range(n):
            wall_start[i] = walls[0]
            if motion[i] > 0.0 and pieces.shape[0] > 0:
                walls = pieces_near(
                    pieces,
                    cells,
                    frame,
                    pose[X, i],
                    pose[Y, i],
                    reach[_WIDE, i],
                    shape[LOWEST, i],
                    shape[HIGHEST, i],
                    walls,
                )
        wall_start[n] = walls[0]
        parent = np.empty(n, dtype=np.int64)
        island = np.empty((3, n))
        any_tight = _islands(shape, pieces, pose, reach, pairs, wall_start, walls, parent, island)
        for i in range(n):
            # Where no proposal can meet anything all of them stand, and nobody has to look.
            if motion[i] > 0.0 and island[0, parent[i]] == 0.0:
                x, y, h, _, _ = arc(pose[X, i], pose[Y, i], pose[HEADING, i], twist[TRAVEL, i], twist[TURN, i])
                outcome[END_X, i], outcome[END_Y, i], outcome[END_HEADING, i] = x, y, h
                outcome[FORWARD, i], outcome[TURNED, i] = twist[TRAVEL, i], twist[TURN, i]
        if any_tight:
            count = pairs[0] - 1
            around = np.empty(count + walls[0] - walls[1], dtype=np.int64)
            edge = np.empty(count, dtype=np.int64)
            edge_hit = np.empty(count // 2, dtype=np.int64)
            index = np.zeros((n + 1, 5), dtype=np.int64)
            for k in range(walls[1], walls[0]):
                around[count + k - walls[1]] = walls[k]
            for k in range(1, pairs[0]):
                index[pairs[k] + 1, OF_NEAR] += 1
            for i in range(n):
                index[i, OF_KEY], index[i, OF_ANCHORED] = marks[KEY, i], marks[ANCHORED, i]
                index[i, OF_PARTS], index[i + 1, OF_PARTS] = part_start[i], part_start[i + 1]
                index[i, OF_WALLS] = count + wall_start[i] - walls[1]
                index[i + 1, OF_WALLS] = count + wall_start[i + 1] - walls[1]
                index[i + 1, OF_NEAR] += index[i, OF_NEAR]
            # Filled from the end of each body's stretch, whose place the end then gives up.
            for e in range(count // 2):
                edge_hit[e] = -1
                for side in range(2):
                    i, j = pairs[1 + 2 * e + side], pairs[2 + 2 * e - side]
                    index[i + 1, OF_NEAR] -= 1
                    around[index[i + 1, OF_NEAR]], edge[index[i + 1, OF_NEAR]] = j, e
            for i in range(n):
                index[i, OF_NEAR] = index[i + 1, OF_NEAR]
            index[n, OF_NEAR] = count
            old = spots_of(pose, shape, licence)
            proposal, result, gain = np.empty((n, 5)), np.empty((n, 5)), np.empty((2, n))
            status = np.zeros((5, n), dtype=np.int64)
            # Members of an island are linked from its root on, ascending: following, last, how many.
            links_of = np.zeros((3, n), dtype=np.int64)
            for i in range(n):
                # What does not move stays in every sub-step; members say so anew in each.
                status[_STAY, i] = 1
                if motion[i] > 0.0 and island[0, parent[i]] != 0.0:
                    root = parent[i]
                    if links_of[2, root] > 0:
                        links_of[0, links_of[1, root]] = i
                    links_of[1, root] = i
                    links_of[2, root] += 1
            members, queue = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
            ref = old.copy()
            for root in range(n):
                if links_of[2, root] == 0:
                    continue
                i = root
                for k in range(links_of[2, root]):
                    members[k] = i
                    i = links_of[0, i]
                quotient = np.ceil(island[1, root] / min(_LONGEST_STEP, 0.5 * island[2, root]))
                used = _settle(
                    parts, pieces, links, edges, index, around, old, ref, proposal, result, status, gain, queue,
                    members[: links_of[2, root]], int(min(quotient, float(_MOST_STEPS))), tick,
                    pose, twist, motion, outcome, flags, hits, hit_numbers, edge, edge_hit, used,
                )  # fmt: skip
    if licensed:
        for i in range(n):
            if (
                licence[i] > 0.0
                and _overlap(parts, part_start, shape, pieces, links, edges, cells, frame, outcome, i) <= TOLERANCE
            ):
                outcome[LICENCE, i] = 0.0
    return int(used)


# ---------------------------------------------------------------- being put somewhere


@njit(cache=True, error_model="numpy")
def _walls_at(pieces: Floats, cells: Ints, frame: Floats, shape: Floats, pose: Floats, i: int) -> Ints:
    found = np.empty(16, dtype=np.int64)
    found[0] = found[1] = 2
    if pieces.shape[0] == 0:
        return found
    return pieces_near(
        pieces, cells, frame, pose[X, i], pose[Y, i], shape[RADIUS, i], shape[LOWEST, i], shape[HIGHEST, i], found
    )


@njit(cache=True, error_model="numpy")
def _overlap(
    parts: Floats,
    part_start: Ints,
    shape: Floats,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
    pose: Floats,
    i: int,
) -> float:
    """Return the largest depth of body i in anything, m, 0 if it overlaps nothing."""
    x, y = pose[X, i], pose[Y, i]
    s, c = sincos(pose[HEADING, i])
    found = _walls_at(pieces, cells, frame, shape, pose, i)
    part0, part1 = part_start[i], part_start[i + 1]
    depth, _ = deepest_piece(
        parts, part0, part1, shape[RADIUS, i], pieces, links, edges, found, found[1], found[0], x, y, c, s, 0.0
    )
    for j in range(part_start.shape[0] - 1):
        dx, dy = pose[X, j] - x, pose[Y, j] - y
        both = shape[RADIUS, i] + shape[RADIUS, j]
        if j != i and dx * dx + dy * dy <= both * both:
            sj, cj = sincos(pose[HEADING, j])
            depth = body_depth(
                parts, part0, part1, x, y, c, s,
                parts, part_start[j], part_start[j + 1], pose[X, j], pose[Y, j], cj, sj, depth,
            )  # fmt: skip
    return depth


@njit(cache=True, error_model="numpy")
def decree(
    parts: Floats,
    part_start: Ints,
    shape: Floats,
    marks: Ints,  # noqa: ARG001 - callers pass a whole `Bodies`
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
    pose: Floats,
    who: Ints,
    licence: Floats,
) -> None:
    """Give bodies that were put where they are the licence to be as deep as they are.

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
        pose: float64[3, n], after all were put.
        who: int64[k], indices of those that were put: spawned, teleported, reported by a real chair.
        licence: float64[n], m; set for them, unchanged for all others.
    """
    for i in who:
        depth = _overlap(parts, part_start, shape, pieces, links, edges, cells, frame, pose, i)
        licence[i] = depth if depth > TOLERANCE else 0.0


@njit(cache=True, error_model="numpy")
def overlaps(
    parts: Floats,
    part_start: Ints,
    shape: Floats,
    marks: Ints,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
    pose: Floats,
    who: Ints,
    hits: Ints,
    hit_numbers: Floats,
) -> int:
    """Write down what some bodies overlap as they stand: for real chairs, whose reported pose is taken as it is.

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
        pose: float64[3, n].
        who: int64[k], indices asked for; a pair of two of them is written down once.
        hits: int64[room, 6], out, as for `resolve`; who is 1, the body asked for comes first.
        hit_numbers: float64[room, 6], out; closing is 0.

    Returns:
        How many hits there are, possibly more than there is room for.
    """
    n = pose.shape[1]
    still = np.zeros((2, n))
    spots = spots_of(pose, shape, still[0])
    index = np.zeros((n + 1, 5), dtype=np.int64)
    for i in range(n):
        index[i, OF_KEY] = marks[KEY, i]
        index[i, OF_PARTS], index[i + 1, OF_PARTS] = part_start[i], part_start[i + 1]
    asked = np.zeros(n, dtype=np.int64)
    for i in who:
        asked[i] = 1
    used = hits.shape[0] - hits.shape[0]  # as in `resolve`
    for i in who:
        x, y, c, s = spots[i, SPOT_X], spots[i, SPOT_Y], spots[i, SPOT_C], spots[i, SPOT_S]
        found = _walls_at(pieces, cells, frame, shape, pose, i)
        _, piece = deepest_piece(
            parts, part_start[i], part_start[i + 1], shape[RADIUS, i], pieces, links, edges,
            found, found[1], found[0], x, y, c, s, TOLERANCE,
        )  # fmt: skip
        # The walls first, as partner -1 of the loop.
        for j in range(-1, n):
            partner = j
            if j < 0:
                if piece < 0:
                    continue
                partner = A_WALL - piece
            else:
                dx, dy = spots[j, SPOT_X] - x, spots[j, SPOT_Y] - y
                both = shape[RADIUS, i] + shape[RADIUS, j]
                if j == i or (asked[j] != 0 and j < i) or dx * dx + dy * dy > both * both:
                    continue
                if spot_depth(parts, index, spots, i, spots, j, TOLERANCE) <= TOLERANCE:
                    continue
            _put_down(
                parts, pieces, links, edges, index, spots, still, i, spots, partner, spots, asked[i],
                hits, hit_numbers, used,
            )  # fmt: skip
            used += 1
    return int(used)


@njit(cache=True, error_model="numpy")
def depth_between(parts: Floats, part_start: Ints, pose: Floats, i: int, j: int) -> float:
    """Return the depth of body i in body j, m: below 0 a gap, -inf if their z have nothing in common.

    Args:
        parts: Part block.
        part_start: First part of each body.
        pose: float64[3, n].
        i: One body.
        j: Another.
    """
    si, ci = sincos(pose[HEADING, i])
    sj, cj = sincos(pose[HEADING, j])
    return body_depth(
        parts, part_start[i], part_start[i + 1], pose[X, i], pose[Y, i], ci, si,
        parts, part_start[j], part_start[j + 1], pose[X, j], pose[Y, j], cj, sj, -np.inf,
    )  # fmt: skip
