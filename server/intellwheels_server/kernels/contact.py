"""Contact: what becomes of the arcs that bodies want to drive when something is in the way.

Nobody pushes anybody. All bodies propose, those whose proposals may not stand are found together, and each of them
then looks for the best it can do alone. Nothing here depends on the order of bodies in the arrays: every
decision is a largest, a least or an any, with ties broken by wall index and key.

Words: m = |travel| + |turn| r bounds how far any point of a body moves in the tick, r being its farthest corner. A
partner is what a body could meet: circles of r + |travel| + m meet. An island is a set of movers connected by
partnership. `FREE` is who still got every proposal of the tick; `STAY` who does not get the present one.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from intellwheels_server.kernels.arrays import (
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
from intellwheels_server.kernels.elementary import sincos
from intellwheels_server.kernels.geometry import arc, body_depth
from intellwheels_server.kernels.neighbours import pairs_near, piece_apart, pieces_near
from intellwheels_server.kernels.standing import (
    A_WALL,
    SPOT_C,
    SPOT_H,
    SPOT_S,
    SPOT_X,
    SPOT_Y,
    TOLERANCE,
    Scene,
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

# Rows of a ledger's status, int64[5, n]: still got every proposal of the tick; has no proposal in this sub-step; is in
# the queue of those; got its proposal after all; goes back, since another's result conflicts.
_FREE, _STAY, _NOTED, _GOT, _BACK = 0, 1, 2, 3, 4
# Places of a ledger's counts: hits so far; length of the queue.
_HITS, _QUEUED = 0, 1

# The bit of a collision flag that says that the wall was written down; taken off at the end.
_WALL_KNOWN = 2


class _Ledger(NamedTuple):
    """What is written down. `edge` numbers the pairs of `Scene.near`, `edge_hit` has the hit of each or -1."""

    twist: Floats
    flags: Ints
    hits: Ints
    hit_numbers: Floats
    edge: Ints
    edge_hit: Ints
    status: Ints
    queue: Ints
    counts: Ints


@njit(cache=True, error_model="numpy")
def _alone(
    scene: Scene, i: int, proposal: Floats, travel: float, turn: float, most: float, result: Floats
) -> tuple[bool, float, float]:
    """Find the best body i can do in this sub-step with all others where they are, and put it in `result`.

    Args:
        scene: The scene.
        i: The body.
        proposal: Spots proposed.
        travel: Of the sub-step, m.
        turn: Of the sub-step, rad.
        most: m of the sub-step, the farthest it may be moved out.
        result: Spots, out.

    Returns:
        Whether it gets its proposal to the bit; forward travel, m, and turn, rad, achieved.
    """
    copy_spot(result, scene.old, i)
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
        if 0 < attempt <= 3 and (scene.marks[ANCHORED, i] != 0 or (d == 0.0 and a == 0.0)):
            continue
        if attempt == 0:
            x, y, h = proposal[i, SPOT_X], proposal[i, SPOT_Y], proposal[i, SPOT_H]
            c, s = proposal[i, SPOT_C], proposal[i, SPOT_S]
        else:
            x, y, h, c, s = arc(scene.old[i, SPOT_X], scene.old[i, SPOT_Y], scene.old[i, SPOT_H], d, a)
        found, px, py = slide(scene, i, x, y, c, s, allowed)
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
def _note(ledger: _Ledger, i: int) -> None:
    """Put a body in the queue of those who get no proposal in this sub-step."""
    if ledger.status[_NOTED, i] == 0:
        ledger.status[_NOTED, i] = 1
        ledger.queue[ledger.counts[_QUEUED]] = i
        ledger.counts[_QUEUED] += 1


@njit(cache=True, error_model="numpy")
def _put_down(scene: Scene, ledger: _Ledger, i: int, at: Floats, partner: int, others_at: Floats, who: int) -> None:
    """Write down that i met a partner, if there is room."""
    used = ledger.counts[_HITS]
    ledger.counts[_HITS] += 1
    if used >= ledger.hits.shape[0]:
        return
    depth, nx, ny, part, other_part, px, py = contact_of(
        scene, i, at[i, SPOT_X], at[i, SPOT_Y], at[i, SPOT_C], at[i, SPOT_S], partner, others_at
    )
    twist, old = ledger.twist, scene.old
    speed_x = twist[TRAVEL, i] * old[i, SPOT_C] - twist[TURN, i] * (py - old[i, SPOT_Y])
    speed_y = twist[TRAVEL, i] * old[i, SPOT_S] + twist[TURN, i] * (px - old[i, SPOT_X])
    wall = -1
    if partner >= 0:
        speed_x -= twist[TRAVEL, partner] * old[partner, SPOT_C] - twist[TURN, partner] * (py - old[partner, SPOT_Y])
        speed_y -= twist[TRAVEL, partner] * old[partner, SPOT_S] + twist[TURN, partner] * (px - old[partner, SPOT_X])
    else:
        other_part = A_WALL - partner
        wall = scene.links[other_part, WALL]
    hits, numbers = ledger.hits, ledger.hit_numbers
    hits[used, HIT_BODY], hits[used, HIT_OTHER], hits[used, HIT_WALL] = i, max(partner, A_WALL), wall
    hits[used, HIT_PART], hits[used, HIT_OTHER_PART], hits[used, HIT_WHO] = part, other_part, who
    numbers[used, HIT_X], numbers[used, HIT_Y] = px, py
    numbers[used, HIT_NORMAL_X], numbers[used, HIT_NORMAL_Y] = nx, ny
    numbers[used, HIT_DEPTH], numbers[used, HIT_CLOSING] = depth, -(speed_x * nx + speed_y * ny)


@njit(cache=True, error_model="numpy")
def _meet(scene: Scene, ledger: _Ledger, proposal: Floats, i: int, j: int, edge: int) -> None:
    """Note i, and j unless it stays, when i's proposal may not stand against j where others see it; and who collides.

    Who comes deeper into the other, or nearer to it, by its own proposal alone, collides.
    """
    if may_stand(scene, proposal, i, scene.ref, j):
        return
    was = spot_depth(scene, scene.old, i, scene.old, j, -np.inf)
    who = 0
    for side in range(2 if ledger.status[_STAY, j] == 0 else 1):
        a, b = (i, j) if side == 0 else (j, i)
        _note(ledger, a)
        if spot_depth(scene, proposal, a, scene.old, b, -np.inf) > was + TOLERANCE:
            ledger.flags[COLLISION, a] |= 1
            who |= 1 << side
    if who == 0:
        return
    ledger.flags[CONTACT, i] = 1
    ledger.flags[CONTACT, j] = 1
    # In a hit the lower index comes first.
    first, second, at, others_at = i, j, proposal, scene.ref
    if i > j:
        first, second, at, others_at = j, i, scene.ref, proposal
        who = ((who & 1) << 1) | (who >> 1)
    known = ledger.edge_hit[edge]
    if known < 0:
        ledger.edge_hit[edge] = ledger.counts[_HITS]
        _put_down(scene, ledger, first, at, second, others_at, who)
    elif known < ledger.hits.shape[0]:
        ledger.hits[known, HIT_WHO] |= who


@njit(cache=True, error_model="numpy")
def _settle(
    scene: Scene,
    ledger: _Ledger,
    members: Ints,
    steps: int,
    tick: int,
    pose: Floats,
    motion: Floats,
    proposal: Floats,
    result: Floats,
    gain: Floats,
    outcome: Floats,
) -> None:
    """Move the members of one island through their sub-steps. `gain` has rows: forward travel, turn of a sub-step."""
    twist, status, queue, counts = ledger.twist, ledger.status, ledger.queue, ledger.counts
    for i in members:
        status[_FREE, i] = 1
    for step in range(steps):
        for i in members:
            share = 1.0 / steps
            x, y, h = scene.old[i, SPOT_X], scene.old[i, SPOT_Y], scene.old[i, SPOT_H]
            if status[_FREE, i] != 0:
                share = (step + 1) / steps
                x, y, h = pose[X, i], pose[Y, i], pose[HEADING, i]
            x, y, h, c, s = arc(x, y, h, share * twist[TRAVEL, i], share * twist[TURN, i])
            set_spot(proposal, i, x, y, h, c, s)
            copy_spot(scene.ref, proposal, i)
            status[_STAY, i] = 0
            status[_NOTED, i] = 0
        # Who has to stay: first everybody is at proposals, then those found are seen where they were.
        counts[_QUEUED] = 0
        for i in members:
            excess, _, partner = wall_excess(
                scene, i, proposal[i, SPOT_X], proposal[i, SPOT_Y], proposal[i, SPOT_C], proposal[i, SPOT_S]
            )
            if excess > 0.0:
                _note(ledger, i)
                if ledger.flags[COLLISION, i] & _WALL_KNOWN == 0:
                    ledger.flags[COLLISION, i] |= 1 | _WALL_KNOWN
                    ledger.flags[CONTACT, i] = 1
                    _put_down(scene, ledger, i, proposal, partner, scene.ref, ledger.flags[COLLISION, i] & 1)
            for k in range(scene.near_start[i], scene.near_start[i + 1]):
                j = scene.near[k]
                if j > i or status[_STAY, j] != 0:
                    _meet(scene, ledger, proposal, i, j, ledger.edge[k])
        first = 0
        while first < counts[_QUEUED]:
            last = counts[_QUEUED]
            for q in range(first, last):
                i = queue[q]
                status[_STAY, i] = 1
                copy_spot(scene.ref, scene.old, i)
            for q in range(first, last):
                j = queue[q]
                for k in range(scene.near_start[j], scene.near_start[j + 1]):
                    i = scene.near[k]
                    if status[_STAY, i] == 0:
                        _meet(scene, ledger, proposal, i, j, ledger.edge[k])
            first = last
        stay = queue[: counts[_QUEUED]]
        for i in stay:
            taken, gain[0, i], gain[1, i] = _alone(
                scene, i, proposal, twist[TRAVEL, i] / steps, twist[TURN, i] / steps, motion[i] / steps, result
            )
            status[_GOT, i] = 1 if taken else 0
            status[_BACK, i] = 0
        for i in stay:
            for k in range(scene.near_start[i], scene.near_start[i + 1]):
                j = scene.near[k]
                if j < i or status[_NOTED, j] == 0 or may_stand(scene, result, i, result, j):
                    continue
                lot_i, lot_j = lot(scene.marks[KEY, i], tick, step), lot(scene.marks[KEY, j], tick, step)
                i_back = lot_i < lot_j or (lot_i == lot_j and scene.marks[KEY, i] > scene.marks[KEY, j])
                status[_BACK, i if i_back else j] = 1
        for i in members:
            if status[_STAY, i] == 0:
                copy_spot(scene.old, proposal, i)
                outcome[FORWARD, i] += twist[TRAVEL, i] / steps
                outcome[TURNED, i] += twist[TURN, i] / steps
            elif status[_BACK, i] == 0:
                copy_spot(scene.old, result, i)
                outcome[FORWARD, i] += gain[0, i]
                outcome[TURNED, i] += gain[1, i]
                status[_FREE, i] &= status[_GOT, i]
            else:
                status[_FREE, i] = 0
    for i in members:
        copy_spot(scene.ref, scene.old, i)
        outcome[END_X, i], outcome[END_Y, i] = scene.old[i, SPOT_X], scene.old[i, SPOT_Y]
        outcome[END_HEADING, i] = scene.old[i, SPOT_H]
        ledger.flags[COLLISION, i] &= 1
        if status[_FREE, i] != 0:
            outcome[FORWARD, i], outcome[TURNED, i] = twist[TRAVEL, i], twist[TURN, i]
            continue
        ledger.flags[BLOCKED, i] = 1
        dx, dy = outcome[END_X, i] - pose[X, i], outcome[END_Y, i] - pose[Y, i]
        achieved = np.sqrt(dx * dx + dy * dy) + abs(outcome[TURNED, i]) * scene.shape[RADIUS, i]
        if achieved < _STALL_SHARE * motion[i]:
            ledger.flags[STALLED, i] = 1


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
    used = 0
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
            count = (pairs[0] - 1) // 2
            near_start = np.zeros(n + 2, dtype=np.int64)
            for e in range(1, pairs[0]):
                near_start[pairs[e] + 2] += 1
            for i in range(n):
                near_start[i + 2] += near_start[i + 1]
            near, edge = np.empty(2 * count, dtype=np.int64), np.empty(2 * count, dtype=np.int64)
            for e in range(count):
                for side in range(2):
                    i, j = pairs[1 + 2 * e + side], pairs[2 + 2 * e - side]
                    at = near_start[i + 1]
                    near[at], edge[at] = j, e
                    near_start[i + 1] += 1
            old = spots_of(pose)
            scene = Scene(
                parts, part_start, shape, marks, pieces, links, edges, licence,
                old, old.copy(), near_start, near, wall_start, walls,
            )  # fmt: skip
            ledger = _Ledger(
                twist, flags, hits, hit_numbers, edge, np.full(count, -1, dtype=np.int64),
                np.zeros((5, n), dtype=np.int64), np.empty(n, dtype=np.int64), np.zeros(2, dtype=np.int64),
            )  # fmt: skip
            for i in range(n):
                # What does not move stays in every sub-step; members say so anew in each.
                ledger.status[_STAY, i] = 1
            # Members of an island are linked from its root on, ascending.
            following = np.empty(n, dtype=np.int64)
            last = np.empty(n, dtype=np.int64)
            size = np.zeros(n, dtype=np.int64)
            for i in range(n):
                if motion[i] > 0.0 and island[0, parent[i]] != 0.0:
                    root = parent[i]
                    if size[root] > 0:
                        following[last[root]] = i
                    last[root] = i
                    size[root] += 1
            proposal, result, gain = np.empty((n, 5)), np.empty((n, 5)), np.empty((2, n))
            members = np.empty(n, dtype=np.int64)
            for root in range(n):
                if size[root] == 0:
                    continue
                i = root
                for k in range(size[root]):
                    members[k] = i
                    i = following[i]
                quotient = np.ceil(island[1, root] / min(_LONGEST_STEP, 0.5 * island[2, root]))
                steps = int(min(quotient, float(_MOST_STEPS)))
                _settle(
                    scene, ledger, members[: size[root]], steps, tick, pose, motion, proposal, result, gain, outcome
                )
            used = int(ledger.counts[_HITS])
    if licensed:
        for i in range(n):
            if (
                licence[i] > 0.0
                and _overlap(parts, part_start, shape, pieces, links, edges, cells, frame, outcome, i) <= TOLERANCE
            ):
                outcome[LICENCE, i] = 0.0
    return used


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
    spots = spots_of(pose)
    none = np.zeros(0, dtype=np.int64)
    status = np.zeros((1, n), dtype=np.int64)
    scene = Scene(
        parts, part_start, shape, marks, pieces, links, edges, np.zeros(n), spots, spots, none, none, none, none
    )
    ledger = _Ledger(np.zeros((2, n)), status, hits, hit_numbers, none, none, status, none, np.zeros(2, dtype=np.int64))
    for i in who:
        status[0, i] = 1
    for i in who:
        x, y, c, s = spots[i, SPOT_X], spots[i, SPOT_Y], spots[i, SPOT_C], spots[i, SPOT_S]
        found = _walls_at(pieces, cells, frame, shape, pose, i)
        _, piece = deepest_piece(
            parts, part_start[i], part_start[i + 1], shape[RADIUS, i], pieces, links, edges,
            found, found[1], found[0], x, y, c, s, TOLERANCE,
        )  # fmt: skip
        if piece >= 0:
            _put_down(scene, ledger, i, spots, A_WALL - piece, spots, status[0, i])
        for j in range(n):
            dx, dy = spots[j, SPOT_X] - x, spots[j, SPOT_Y] - y
            both = shape[RADIUS, i] + shape[RADIUS, j]
            if j == i or (status[0, j] != 0 and j < i) or dx * dx + dy * dy > both * both:
                continue
            if spot_depth(scene, spots, i, spots, j, TOLERANCE) > TOLERANCE:
                _put_down(scene, ledger, i, spots, j, spots, status[0, i])
    return int(ledger.counts[_HITS])


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
