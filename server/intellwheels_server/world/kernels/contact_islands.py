"""Islands of contact: the movers that could meet one another in a tick, and the partners of each.

An island is a set of movers that are connected because each could meet the next. Islands do not influence each other,
so each is settled alone. An island is tight if a proposed motion in it can meet anything at all. In an island that is
not tight, every proposal is granted without a test.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import (
    ANCHORED,
    EXTERNALLY_POSED,
    HIGHEST,
    KEY,
    LOWEST,
    PIECE_THICKNESS,
    RADIUS,
    THICKNESS,
    TRAVEL,
    TURN,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.broad_phase import pairs_near, piece_apart, pieces_near
from intellwheels_server.world.kernels.penetration import OF_ANCHORED, OF_KEY, OF_NEAR, OF_PARTS, OF_WALLS

# Rows of a reach block, float64[3, n], m: bound m of the motion of any point of the body; r + |travel| + m, the circle
# in which it may end after sliding; r + |travel|, the circle in which it ends if its proposal is granted.
REACH_MOTION, REACH_SLID, REACH_PROPOSED = 0, 1, 2

# Rows of an island block, float64[3, n], at the least index of an island's members: 1 if it is tight; the largest m of
# its members, m; the thinnest of its members and of what they could meet, m.
ISLAND_TIGHT, ISLAND_MOTION, ISLAND_THICKNESS = 0, 1, 2

# Rows of a member list, int64[3, n]: the member after this one; at an island's least index, its last member and how
# many it has.
NEXT_MEMBER, LAST_MEMBER, MEMBER_COUNT = 0, 1, 2


class Neighbours(NamedTuple):
    """The partners of all bodies in a tick, before they are laid out body by body.

    Attributes:
        pairs: int64, pairs of bodies as `broad_phase.pairs_near` returns them.
        wall_start: int64[n + 1], where the wall pieces of each body begin in `near_walls`, and the end.
        near_walls: int64, wall pieces as `broad_phase.pieces_near` returns them.
    """

    pairs: Ints
    wall_start: Ints
    near_walls: Ints


class Partners(NamedTuple):
    """The partners in a tick, body by body.

    Attributes:
        layout: int64[n + 1, 5], columns `OF_KEY` to `OF_WALLS` of `penetration`.
        around: int64, bodies and then wall pieces, at the places that `layout` gives.
        pair_of: int64, for each body in `around` the number of the pair.
        pair_hit: int64[pairs], the recorded hit of each pair, -1 for none.
    """

    layout: Ints
    around: Ints
    pair_of: Ints
    pair_hit: Ints


@njit(cache=True, error_model="numpy", inline="always")
def reaches(shape: Floats, marks: Ints, twist: Floats) -> Floats:
    """Return how far each body can get in the tick, a reach block, float64[3, n].

    Args:
        shape: Shape block of the bodies, float64[4, n].
        marks: int64[3, n]; an externally posed body does not move.
        twist: float64[2, n], m and rad.
    """
    reach = np.empty((3, twist.shape[1]))
    for i in range(twist.shape[1]):
        d, a = abs(twist[TRAVEL, i]), abs(twist[TURN, i])
        if marks[EXTERNALLY_POSED, i] != 0:
            d = a = 0.0
        reach[REACH_MOTION, i] = d + a * shape[RADIUS, i]
        reach[REACH_SLID, i] = shape[RADIUS, i] + d + reach[REACH_MOTION, i]
        reach[REACH_PROPOSED, i] = shape[RADIUS, i] + d
    return reach


@njit(cache=True, error_model="numpy", inline="always")
def neighbours_of(shape: Floats, pieces: Floats, cells: Ints, frame: Floats, pose: Floats, reach: Floats) -> Neighbours:
    """Return the partners of all bodies in the tick.

    Args:
        shape: Shape block of the bodies, float64[4, n].
        pieces: Of the walls, as the next two.
        cells: Of the walls.
        frame: Of the walls.
        pose: float64[3, n].
        reach: float64[3, n].
    """
    n = pose.shape[1]
    motion = reach[REACH_MOTION]
    pairs = pairs_near(shape, pose, motion, reach[REACH_SLID])
    wall_start = np.empty(n + 1, dtype=np.int64)
    near_walls = np.empty(2 + 8 * n, dtype=np.int64)
    near_walls[0] = near_walls[1] = 2
    for i in range(n):
        wall_start[i] = near_walls[0]
        if motion[i] > 0.0 and pieces.shape[0] > 0:
            near_walls = pieces_near(
                pieces, cells, frame, pose[rows.X, i], pose[rows.Y, i], reach[REACH_SLID, i], shape[LOWEST, i],
                shape[HIGHEST, i], near_walls,
            )  # fmt: skip
    wall_start[n] = near_walls[0]
    return Neighbours(pairs, wall_start, near_walls)


@njit(cache=True, error_model="numpy")
def _root(parent: Ints, i: int) -> int:
    """Return the least index of the island of mover i."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@njit(cache=True, error_model="numpy", inline="always")
def find_islands(
    shape: Floats, pieces: Floats, pose: Floats, reach: Floats, neighbours: Neighbours, parent: Ints, island: Floats
) -> bool:
    """Fill in the islands; return whether any is tight.

    Args:
        shape: Shape block of the bodies, float64[4, n].
        pieces: Of the walls.
        pose: float64[3, n].
        reach: float64[3, n].
        neighbours: The partners of all bodies.
        parent: int64[n], out: for a mover the least index of its island.
        island: float64[3, n], out, an island block.
    """
    pairs, wall_start, near_walls = neighbours
    n = pose.shape[1]
    for i in range(n):
        parent[i] = i
        island[ISLAND_TIGHT, i] = 0.0
        island[ISLAND_MOTION, i] = 0.0
        island[ISLAND_THICKNESS, i] = np.inf
    for e in range(1, pairs[0], 2):
        i, j = pairs[e], pairs[e + 1]
        if reach[REACH_MOTION, i] > 0.0 and reach[REACH_MOTION, j] > 0.0:
            i, j = _root(parent, i), _root(parent, j)
            parent[max(i, j)] = min(i, j)
    any_tight = False
    for i in range(n):
        if reach[REACH_MOTION, i] <= 0.0:
            continue
        root = _root(parent, i)
        parent[i] = root
        island[ISLAND_MOTION, root] = max(island[ISLAND_MOTION, root], reach[REACH_MOTION, i])
        island[ISLAND_THICKNESS, root] = min(island[ISLAND_THICKNESS, root], shape[THICKNESS, i])
        for k in range(wall_start[i], wall_start[i + 1]):
            piece = near_walls[k]
            island[ISLAND_THICKNESS, root] = min(island[ISLAND_THICKNESS, root], pieces[piece, PIECE_THICKNESS])
            if not piece_apart(pieces, piece, pose[rows.X, i], pose[rows.Y, i], reach[REACH_PROPOSED, i]):
                island[ISLAND_TIGHT, root] = 1.0
                any_tight = True
    for e in range(1, pairs[0], 2):
        i, j = pairs[e], pairs[e + 1]
        root = parent[i] if reach[REACH_MOTION, i] > 0.0 else parent[j]
        island[ISLAND_THICKNESS, root] = min(island[ISLAND_THICKNESS, root], shape[THICKNESS, i], shape[THICKNESS, j])
        dx, dy = pose[rows.X, j] - pose[rows.X, i], pose[rows.Y, j] - pose[rows.Y, i]
        both = reach[REACH_PROPOSED, i] + reach[REACH_PROPOSED, j]
        if dx * dx + dy * dy <= both * both:
            island[ISLAND_TIGHT, root] = 1.0
            any_tight = True
    return any_tight


@njit(cache=True, error_model="numpy", inline="always")
def partners_of(part_start: Ints, marks: Ints, neighbours: Neighbours) -> Partners:
    """Return the partners, laid out body by body.

    Args:
        part_start: int64[n + 1], the first part of each body and the end.
        marks: int64[3, n], of the bodies.
        neighbours: The partners of all bodies.
    """
    pairs, wall_start, near_walls = neighbours
    n = marks.shape[1]
    count = pairs[0] - 1
    around = np.empty(count + near_walls[0] - near_walls[1], dtype=np.int64)
    pair_of = np.empty(count, dtype=np.int64)
    pair_hit = np.empty(count // 2, dtype=np.int64)
    index = np.zeros((n + 1, 5), dtype=np.int64)
    for k in range(near_walls[1], near_walls[0]):
        around[count + k - near_walls[1]] = near_walls[k]
    for k in range(1, pairs[0]):
        index[pairs[k] + 1, OF_NEAR] += 1
    for i in range(n):
        index[i, OF_KEY], index[i, OF_ANCHORED] = marks[KEY, i], marks[ANCHORED, i]
        index[i, OF_PARTS], index[i + 1, OF_PARTS] = part_start[i], part_start[i + 1]
        index[i, OF_WALLS] = count + wall_start[i] - near_walls[1]
        index[i + 1, OF_WALLS] = count + wall_start[i + 1] - near_walls[1]
        index[i + 1, OF_NEAR] += index[i, OF_NEAR]
    # The range of each body is filled from its end. The entry in the index counts down to the start of the range.
    for e in range(count // 2):
        pair_hit[e] = -1
        for side in range(2):
            i, j = pairs[1 + 2 * e + side], pairs[2 + 2 * e - side]
            index[i + 1, OF_NEAR] -= 1
            around[index[i + 1, OF_NEAR]], pair_of[index[i + 1, OF_NEAR]] = j, e
    for i in range(n):
        index[i, OF_NEAR] = index[i + 1, OF_NEAR]
    index[n, OF_NEAR] = count
    return Partners(index, around, pair_of, pair_hit)


@njit(cache=True, error_model="numpy", inline="always")
def list_members(reach: Floats, parent: Ints, island: Floats) -> Ints:
    """Return the movers of each tight island in ascending order, a member list, int64[3, n].

    Args:
        reach: float64[3, n].
        parent: int64[n], as `find_islands` fills it in.
        island: float64[3, n], as `find_islands` fills it in.
    """
    n = parent.shape[0]
    listed = np.zeros((3, n), dtype=np.int64)
    for i in range(n):
        if reach[REACH_MOTION, i] > 0.0 and island[ISLAND_TIGHT, parent[i]] != 0.0:
            root = parent[i]
            if listed[MEMBER_COUNT, root] > 0:
                listed[NEXT_MEMBER, listed[LAST_MEMBER, root]] = i
            listed[LAST_MEMBER, root] = i
            listed[MEMBER_COUNT, root] += 1
    return listed
