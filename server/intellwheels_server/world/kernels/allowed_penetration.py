"""Allowed penetration: a body that was put into something may stay as deep as it was then, and may leave.

Only a body that is spawned, teleported or reported by a real chair can overlap something. The depth that it then has is
its allowed penetration until it overlaps nothing any more.
"""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import HIGHEST, KEY, LOWEST, RADIUS, Bodies, Floats, Ints, Walls
from intellwheels_server.world.kernels.broad_phase import pieces_near
from intellwheels_server.world.kernels.contact_hits import record_hit
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.geometry import body_depth
from intellwheels_server.world.kernels.penetration import (
    A_WALL,
    OF_KEY,
    OF_PARTS,
    SPOT_C,
    SPOT_S,
    SPOT_X,
    SPOT_Y,
    TOLERANCE,
    deepest_piece,
    spot_depth,
    spots_of,
)


@njit(cache=True, error_model="numpy")
def _walls_at(pieces: Floats, cells: Ints, frame: Floats, shape: Floats, pose: Floats, i: int) -> Ints:
    """Return the wall pieces near body i, as `pieces_near` does."""
    found = np.empty(16, dtype=np.int64)
    found[0] = found[1] = 2
    if pieces.shape[0] == 0:
        return found
    x, y, radius = pose[rows.X, i], pose[rows.Y, i], shape[RADIUS, i]
    return pieces_near(pieces, cells, frame, x, y, radius, shape[LOWEST, i], shape[HIGHEST, i], found)


@njit(cache=True, error_model="numpy")
def deepest_overlap(bodies: Bodies, walls: Walls, pose: Floats, i: int) -> float:
    """Return the largest depth of body i in anything, m, 0 if it overlaps nothing.

    Args:
        bodies: Their shapes.
        walls: The walls.
        pose: float64[>= 3, n].
        i: The body.
    """
    (parts, part_start, shape, _), (pieces, links, edges, cells, frame) = bodies, walls
    x, y = pose[rows.X, i], pose[rows.Y, i]
    s, c = sincos(pose[rows.HEADING, i])
    found = _walls_at(pieces, cells, frame, shape, pose, i)
    part0, part1 = part_start[i], part_start[i + 1]
    depth, _ = deepest_piece(
        parts, part0, part1, shape[RADIUS, i], pieces, links, edges, found, found[1], found[0], x, y, c, s, 0.0
    )
    for j in range(part_start.shape[0] - 1):
        dx, dy = pose[rows.X, j] - x, pose[rows.Y, j] - y
        both = shape[RADIUS, i] + shape[RADIUS, j]
        if j != i and dx * dx + dy * dy <= both * both:
            sj, cj = sincos(pose[rows.HEADING, j])
            depth = body_depth(
                parts, part0, part1, x, y, c, s,
                parts, part_start[j], part_start[j + 1], pose[rows.X, j], pose[rows.Y, j], cj, sj, depth,
            )  # fmt: skip
    return depth


@njit(cache=True, error_model="numpy")
def allow_overlap(bodies: Bodies, walls: Walls, pose: Floats, who: Ints, allowed: Floats) -> None:
    """Set the allowed penetration of bodies that were put somewhere to their present depth.

    Args:
        bodies: Their shapes.
        walls: The walls.
        pose: float64[>= 3, n], after all were put.
        who: int64[k], indices of the bodies that were put: spawned, teleported, reported by a real chair.
        allowed: float64[n], m; set for these bodies, unchanged for all others.
    """
    for i in who:
        depth = deepest_overlap(bodies, walls, pose, i)
        allowed[i] = depth if depth > TOLERANCE else 0.0


@njit(cache=True, error_model="numpy")
def record_overlaps(bodies: Bodies, walls: Walls, pose: Floats, who: Ints, hits: Ints, hit_numbers: Floats) -> int:
    """Record what some bodies overlap at their poses. For real chairs, whose reported pose is always accepted.

    Args:
        bodies: Their shapes.
        walls: The walls.
        pose: float64[>= 3, n].
        who: int64[k], indices of these bodies; a pair of two of them is recorded once.
        hits: int64[room, 6], out, as for `contact.resolve`; `HIT_WHO` is 1, and the body of `who` comes first.
        hit_numbers: float64[room, 6], out; closing is 0.

    Returns:
        How many hits there are, possibly more than there is room for.
    """
    (parts, part_start, shape, marks), (pieces, links, edges, cells, frame) = bodies, walls
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
    used = hits.shape[0] - hits.shape[0]  # as in `contact.resolve`
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
            record_hit(
                parts, pieces, links, edges, index, spots, still, i, spots, partner, spots, asked[i],
                hits, hit_numbers, used,
            )  # fmt: skip
            used += 1
    return int(used)
