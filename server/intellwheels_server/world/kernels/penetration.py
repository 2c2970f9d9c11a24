"""Penetration: the depth of a body in its partners, which poses are allowed, and how a body is moved out.

A pose is allowed if against every partner the depth is at most the depth at the start of the sub-step, or `TOLERANCE`.
A body that was put into something (spawned, teleported, reported by a real chair) has an allowed penetration: the depth
that it had then. Where it overlapped before, it may be as deep as that until it overlaps nothing any more. So it can
leave. All wall pieces together are one partner.

The functions share their first arguments:
    parts, pieces, links, edges: blocks of the bodies' parts and of the walls, see `arrays`.
    index, around: the partners of each body; the columns of `index` are named below.
    old, ref: spot blocks: the poses at the start of the sub-step, and the poses at which the others see the bodies.
They are passed one by one. These functions are called for every pair in every sub-step, and numba counts the references
to each array of a tuple at every call, which costs more than the depths.
"""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import (
    BOTTOM,
    HALF_LENGTH,
    HALF_WIDTH,
    PART_X,
    PART_Y,
    PIECE_BOTTOM,
    PIECE_TOP,
    RADIUS,
    TOP,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.broad_phase import piece_apart
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.geometry import body_contact, body_depth, piece_contact, piece_depth

# Depth up to which things touch and do not overlap, m: a thousand times the rounding on a map of 10 km.
TOLERANCE = 1e-9

# A body that is pushed out is moved this much farther, m, so that rounding leaves it outside.
_CLEARANCE = 1e-12
_MOST_PUSHES = 8

# Partners are bodies' indices, `NOBODY`, or `A_WALL` minus the index of a wall piece.
NOBODY = -1
A_WALL = -2

# Columns of a spot block, float64[n, 7]: a pose, the cosine and sine of its heading; radius and allowed penetration.
SPOT_X, SPOT_Y, SPOT_H, SPOT_C, SPOT_S, SPOT_RADIUS, SPOT_ALLOWED = 0, 1, 2, 3, 4, 5, 6

# Columns of an index, int64[n + 1, 5]: key of the name; whether it is anchored; first part; where its partners begin in
# `around`; where its wall pieces begin there. The next row says where they end.
OF_KEY, OF_ANCHORED, OF_PARTS, OF_NEAR, OF_WALLS = 0, 1, 2, 3, 4


@njit(cache=True, error_model="numpy")
def set_spot(spots: Floats, i: int, x: float, y: float, heading: float, c: float, s: float) -> None:
    """Set the pose of body i."""
    spots[i, SPOT_X] = x
    spots[i, SPOT_Y] = y
    spots[i, SPOT_H] = heading
    spots[i, SPOT_C] = c
    spots[i, SPOT_S] = s


@njit(cache=True, error_model="numpy")
def beyond_edge(x: float, y: float) -> bool:
    """Return whether a point is beyond the range of coordinates in messages."""
    return abs(x) > rows.WORLD_EDGE or abs(y) > rows.WORLD_EDGE


@njit(cache=True, error_model="numpy")
def copy_spot(spots: Floats, source: Floats, i: int) -> None:
    """Set the pose of body i to another spot."""
    # Not by assigning rows: what numba compiles for its error message takes longer than all of this file.
    for k in range(SPOT_S + 1):
        spots[i, k] = source[i, k]


@njit(cache=True, error_model="numpy")
def spots_of(pose: Floats, shape: Floats, allowed: Floats) -> Floats:
    """Return the spots of all bodies, float64[n, 7]."""
    spots = np.empty((pose.shape[1], 7))
    for i in range(pose.shape[1]):
        s, c = sincos(pose[rows.HEADING, i])
        set_spot(spots, i, pose[rows.X, i], pose[rows.Y, i], pose[rows.HEADING, i], c, s)
        spots[i, SPOT_RADIUS] = shape[RADIUS, i]
        spots[i, SPOT_ALLOWED] = allowed[i]
    return spots


# ---------------------------------------------------------------- depths


@njit(cache=True, error_model="numpy")
def spot_depth(parts: Floats, index: Ints, at: Floats, i: int, others_at: Floats, j: int, floor: float) -> float:
    """Return the depth of body i at its spot in body j at its spot, m, or the lower bound."""
    return body_depth(
        parts, index[i, OF_PARTS], index[i + 1, OF_PARTS],
        at[i, SPOT_X], at[i, SPOT_Y], at[i, SPOT_C], at[i, SPOT_S],
        parts, index[j, OF_PARTS], index[j + 1, OF_PARTS],
        others_at[j, SPOT_X], others_at[j, SPOT_Y], others_at[j, SPOT_C], others_at[j, SPOT_S], floor,
    )  # fmt: skip


@njit(cache=True, error_model="numpy")
def deepest_piece(
    parts: Floats, part0: int, part1: int, radius: float, pieces: Floats, links: Ints, edges: Floats,
    items: Ints, item0: int, item1: int, x: float, y: float, c: float, s: float, floor: float,
) -> tuple[float, int]:  # fmt: skip
    """Return the depth of a body in the walls, m, or the lower bound, and the deepest piece; of equals the first.

    Args:
        parts: Part block of the body.
        part0: Its first part.
        part1: One past its last.
        radius: Its farthest corner, m.
        pieces: Of the walls, as the next two.
        links: Of the walls.
        edges: Of the walls.
        items: Wall pieces that it could meet.
        item0: First of them.
        item1: One past the last.
        x: Its pose.
        y: Its pose.
        c: Cosine of its heading.
        s: Sine of its heading.
        floor: What a depth must exceed to count.
    """
    deepest = NOBODY
    for k in range(item0, item1):
        piece = items[k]
        if piece_apart(pieces, piece, x, y, radius):
            continue
        for p in range(part0, part1):
            if max(parts[p, BOTTOM], pieces[piece, PIECE_BOTTOM]) >= min(parts[p, TOP], pieces[piece, PIECE_TOP]):
                continue
            depth = piece_depth(
                links, edges, piece,
                x + (c * parts[p, PART_X] - s * parts[p, PART_Y]), y + (s * parts[p, PART_X] + c * parts[p, PART_Y]),
                c, s, parts[p, HALF_LENGTH], parts[p, HALF_WIDTH], floor,
            )  # fmt: skip
            if depth > floor:
                floor, deepest = depth, piece
    return floor, deepest


# ---------------------------------------------------------------- points of contact


@njit(cache=True, error_model="numpy")
def contact_of(
    parts: Floats, pieces: Floats, links: Ints, edges: Floats, index: Ints, others_at: Floats,
    i: int, x: float, y: float, c: float, s: float, partner: int,
) -> tuple[float, float, float, int, int, float, float]:  # fmt: skip
    """Return where body i meets a partner: depth, normal along which i leaves it, part, its part, point.

    The parts are counted from the body's first; the partner's part is 0 if it is a wall piece.
    """
    first, end = index[i, OF_PARTS], index[i + 1, OF_PARTS]
    if partner >= 0:
        a, b = first, index[partner, OF_PARTS]
        a1, b1 = end, index[partner + 1, OF_PARTS]
        xa, ya, ca, sa = x, y, c, s
        xb, yb = others_at[partner, SPOT_X], others_at[partner, SPOT_Y]
        cb, sb = others_at[partner, SPOT_C], others_at[partner, SPOT_S]
        # The answer must be the same for both bodies, so the lower key comes first.
        swapped = index[i, OF_KEY] > index[partner, OF_KEY]
        if swapped:
            a, b, a1, b1 = b, a, b1, a1
            xa, ya, ca, sa, xb, yb, cb, sb = xb, yb, cb, sb, xa, ya, ca, sa
        depth, nx, ny, part_a, part_b, px, py = body_contact(parts, a, a1, xa, ya, ca, sa, b, b1, xb, yb, cb, sb)
        if swapped:
            return depth, -nx, -ny, part_b - b, part_a - a, px, py
        return depth, nx, ny, part_a - a, part_b - b, px, py
    piece = A_WALL - partner
    best = -np.inf
    normal_x = normal_y = px = py = 0.0
    part = first
    for p in range(first, end):
        if max(parts[p, BOTTOM], pieces[piece, PIECE_BOTTOM]) >= min(parts[p, TOP], pieces[piece, PIECE_TOP]):
            continue
        depth, nx, ny, qx, qy = piece_contact(
            links, edges, piece,
            x + (c * parts[p, PART_X] - s * parts[p, PART_Y]), y + (s * parts[p, PART_X] + c * parts[p, PART_Y]),
            c, s, parts[p, HALF_LENGTH], parts[p, HALF_WIDTH],
        )  # fmt: skip
        if depth > best:
            best, normal_x, normal_y, part, px, py = depth, nx, ny, p, qx, qy
    return best, normal_x, normal_y, part - first, 0, px, py


# ---------------------------------------------------------------- allowed poses


@njit(cache=True, error_model="numpy")
def _allowed(new: float, old: float, allowed: float) -> tuple[float, float]:
    """Return the excess of a depth over the allowed one, m, and how far to move out to be as deep as before, m."""
    if old > TOLERANCE:
        limit = max(old, allowed)
        return new - limit, new - limit
    return new - TOLERANCE, new - old


@njit(cache=True, error_model="numpy")
def wall_excess(
    parts: Floats, pieces: Floats, links: Ints, edges: Floats, index: Ints, around: Ints, old: Floats,
    i: int, x: float, y: float, c: float, s: float,
) -> tuple[float, float, int]:  # fmt: skip
    """Return by how much body i would be too deep in a wall, m; at most 0 if the pose is allowed.

    Returns:
        The excess; how far to move out, m; the partner, if there is an excess.
    """
    first, end, radius = index[i, OF_PARTS], index[i + 1, OF_PARTS], old[i, SPOT_RADIUS]
    wall0, wall1 = index[i, OF_WALLS], index[i + 1, OF_WALLS]
    excess = leave = 0.0
    new, piece = deepest_piece(
        parts, first, end, radius, pieces, links, edges, around, wall0, wall1, x, y, c, s, TOLERANCE
    )
    if piece >= 0:
        x, y, c, s = old[i, SPOT_X], old[i, SPOT_Y], old[i, SPOT_C], old[i, SPOT_S]
        was, _ = deepest_piece(parts, first, end, radius, pieces, links, edges, around, wall0, wall1, x, y, c, s, 0.0)
        excess, leave = _allowed(new, was, old[i, SPOT_ALLOWED])
    return excess, leave, A_WALL - piece


@njit(cache=True, error_model="numpy")
def body_excess(
    parts: Floats, index: Ints, old: Floats, others_at: Floats, i: int, x: float, y: float, c: float, s: float, j: int
) -> tuple[float, float]:
    """Return by how much body i would be too deep in body j, m, at most 0 if allowed; and how far to move out, m."""
    excess = leave = 0.0
    dx, dy = others_at[j, SPOT_X] - x, others_at[j, SPOT_Y] - y
    reach = old[i, SPOT_RADIUS] + old[j, SPOT_RADIUS]
    if dx * dx + dy * dy <= reach * reach:
        new = body_depth(
            parts, index[i, OF_PARTS], index[i + 1, OF_PARTS], x, y, c, s,
            parts, index[j, OF_PARTS], index[j + 1, OF_PARTS],
            others_at[j, SPOT_X], others_at[j, SPOT_Y], others_at[j, SPOT_C], others_at[j, SPOT_S], TOLERANCE,
        )  # fmt: skip
        if new > TOLERANCE:
            was = spot_depth(parts, index, old, i, old, j, 0.0)
            excess, leave = _allowed(new, was, max(old[i, SPOT_ALLOWED], old[j, SPOT_ALLOWED]))
    return excess, leave


@njit(cache=True, error_model="numpy")
def may_stand(parts: Floats, index: Ints, old: Floats, at: Floats, i: int, others_at: Floats, j: int) -> bool:
    """Return whether the spot of body i is allowed against that of body j."""
    excess, _ = body_excess(
        parts, index, old, others_at, i, at[i, SPOT_X], at[i, SPOT_Y], at[i, SPOT_C], at[i, SPOT_S], j
    )
    return excess <= 0.0


@njit(cache=True, error_model="numpy")
def _worst(
    parts: Floats, pieces: Floats, links: Ints, edges: Floats, index: Ints, around: Ints, old: Floats, ref: Floats,
    i: int, x: float, y: float, c: float, s: float, any_will_do: bool,
) -> tuple[float, float, int]:  # fmt: skip
    """Return the largest excess of body i over all partners.

    Returns:
        The excess, m, 0 if the pose is allowed; how far to move out, m; the partner. Of equals a wall counts first,
        then the lower key. If `any_will_do`, the first partner with an excess.
    """
    excess, leave, partner = wall_excess(parts, pieces, links, edges, index, around, old, i, x, y, c, s)
    if excess <= 0.0:
        excess, partner = 0.0, NOBODY
    for k in range(index[i, OF_NEAR], index[i + 1, OF_NEAR]):
        if any_will_do and excess > 0.0:
            break
        j = around[k]
        over, away = body_excess(parts, index, old, ref, i, x, y, c, s, j)
        if over > excess or (
            over > 0.0 and over == excess and partner >= 0 and index[j, OF_KEY] < index[partner, OF_KEY]
        ):
            excess, leave, partner = over, away, j
    return excess, leave, partner


@njit(cache=True, error_model="numpy")
def slide(
    parts: Floats, pieces: Floats, links: Ints, edges: Floats, index: Ints, around: Ints, old: Floats, ref: Floats,
    i: int, x: float, y: float, c: float, s: float, most: float,
) -> tuple[bool, float, float]:  # fmt: skip
    """Move body i out of the partners in which it is too deep, along the normals, without turning.

    Args:
        parts: As the module says, like the next seven.
        pieces: As the module says.
        links: As the module says.
        edges: As the module says.
        index: As the module says.
        around: As the module says.
        old: As the module says.
        ref: As the module says.
        i: The body.
        x: Its proposed x, m.
        y: Its proposed y, m.
        c: Cosine of its heading.
        s: Sine of its heading.
        most: The farthest that it may be moved in total, m; 0 only tests the proposal.

    Returns:
        Whether the pose is then allowed, and the position.
    """
    moved = 0.0
    for push in range(_MOST_PUSHES + 1):
        last = push == _MOST_PUSHES or most <= 0.0
        excess, leave, partner = _worst(parts, pieces, links, edges, index, around, old, ref, i, x, y, c, s, last)
        if excess <= 0.0:
            return not beyond_edge(x, y), x, y
        leave += _CLEARANCE
        moved += leave
        if last or moved > most:
            break
        _, nx, ny, _, _, _, _ = contact_of(parts, pieces, links, edges, index, ref, i, x, y, c, s, partner)
        x += leave * nx
        y += leave * ny
    return False, x, y
