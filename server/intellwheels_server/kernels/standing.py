"""Where a body may stand, how far it is from that, and where it meets what is in its way.

A pose may stand if against every partner the depth is at most what it was at the start of the sub-step, or
`TOLERANCE`. What was put into something (spawned, teleported, reported by a real chair) has a licence: the depth it
then had. Where it overlapped before, it may be as deep as that, until it overlaps nothing any more. So it can leave.
All wall pieces together are one partner.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from intellwheels_server.kernels.arrays import (
    BOTTOM,
    HALF_LENGTH,
    HALF_WIDTH,
    HEADING,
    KEY,
    PART_X,
    PART_Y,
    PIECE_BOTTOM,
    PIECE_TOP,
    RADIUS,
    TOP,
    Floats,
    Ints,
    X,
    Y,
)
from intellwheels_server.kernels.elementary import sincos
from intellwheels_server.kernels.geometry import body_contact, body_depth, piece_contact, piece_depth
from intellwheels_server.kernels.neighbours import piece_apart

# Depth up to which things touch and do not overlap, m: a thousand times the rounding of a floor of 10 km.
TOLERANCE = 1e-9

# A body pushed out of what it meets lands this much farther, m, so that rounding leaves it outside.
_CLEARANCE = 1e-12
_MOST_PUSHES = 8

# Partners are bodies' indices, `NOBODY`, or `A_WALL` minus the index of a wall piece.
NOBODY = -1
A_WALL = -2

# Columns of a spot block, float64[n, 5]: a pose and the cosine and sine of its heading.
SPOT_X, SPOT_Y, SPOT_H, SPOT_C, SPOT_S = 0, 1, 2, 3, 4


class Scene(NamedTuple):
    """What the functions of one tick look at.

    Attributes:
        parts: Of the bodies, as the next three.
        part_start: Of the bodies.
        shape: Of the bodies.
        marks: Of the bodies.
        pieces: Of the walls, as the next two.
        links: Of the walls.
        edges: Of the walls.
        licence: float64[n], m.
        old: Spots at the start of the sub-step.
        ref: Spots at which the others see a body.
        near_start: int64[n + 1], where the partners of each body begin.
        near: Partners of all bodies.
        wall_start: int64[n + 1], where the wall pieces of each body begin.
        walls: Wall pieces of all bodies, ascending for each.
    """

    parts: Floats
    part_start: Ints
    shape: Floats
    marks: Ints
    pieces: Floats
    links: Ints
    edges: Floats
    licence: Floats
    old: Floats
    ref: Floats
    near_start: Ints
    near: Ints
    wall_start: Ints
    walls: Ints


@njit(cache=True, error_model="numpy")
def set_spot(spots: Floats, i: int, x: float, y: float, heading: float, c: float, s: float) -> None:
    """Set the spot of body i."""
    spots[i, SPOT_X] = x
    spots[i, SPOT_Y] = y
    spots[i, SPOT_H] = heading
    spots[i, SPOT_C] = c
    spots[i, SPOT_S] = s


@njit(cache=True, error_model="numpy")
def copy_spot(spots: Floats, source: Floats, i: int) -> None:
    """Set the spot of body i to another."""
    # Not by assigning rows: what numba compiles for its error message takes longer than all of this file.
    for k in range(5):
        spots[i, k] = source[i, k]


@njit(cache=True, error_model="numpy")
def spots_of(pose: Floats) -> Floats:
    """Return the spots of all bodies, float64[n, 5]."""
    spots = np.empty((pose.shape[1], 5))
    for i in range(pose.shape[1]):
        s, c = sincos(pose[HEADING, i])
        set_spot(spots, i, pose[X, i], pose[Y, i], pose[HEADING, i], c, s)
    return spots


# ---------------------------------------------------------------- depths


@njit(cache=True, error_model="numpy")
def spot_depth(scene: Scene, at: Floats, i: int, others_at: Floats, j: int, floor: float) -> float:
    """Return how deep body i at its spot overlaps body j at its, m, or the floor."""
    return body_depth(
        scene.parts, scene.part_start[i], scene.part_start[i + 1],
        at[i, SPOT_X], at[i, SPOT_Y], at[i, SPOT_C], at[i, SPOT_S],
        scene.parts, scene.part_start[j], scene.part_start[j + 1],
        others_at[j, SPOT_X], others_at[j, SPOT_Y], others_at[j, SPOT_C], others_at[j, SPOT_S], floor,
    )  # fmt: skip


@njit(cache=True, error_model="numpy")
def deepest_piece(
    parts: Floats,
    part0: int,
    part1: int,
    radius: float,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    items: Ints,
    item0: int,
    item1: int,
    x: float,
    y: float,
    c: float,
    s: float,
    floor: float,
) -> tuple[float, int]:
    """Return how deep a body overlaps the walls, m, or the floor, and the deepest piece: of equals the first.

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


@njit(cache=True, error_model="numpy")
def _wall_depth(scene: Scene, i: int, x: float, y: float, c: float, s: float, floor: float) -> tuple[float, int]:
    return deepest_piece(
        scene.parts, scene.part_start[i], scene.part_start[i + 1], scene.shape[RADIUS, i],
        scene.pieces, scene.links, scene.edges, scene.walls, scene.wall_start[i], scene.wall_start[i + 1],
        x, y, c, s, floor,
    )  # fmt: skip


# ---------------------------------------------------------------- where two meet


@njit(cache=True, error_model="numpy")
def contact_of(
    scene: Scene, i: int, x: float, y: float, c: float, s: float, partner: int, others_at: Floats
) -> tuple[float, float, float, int, int, float, float]:
    """Return where body i meets a partner: depth, normal along which i leaves it, part, its part, point.

    The parts are counted from the body's first; the partner's part is 0 if it is a wall piece.
    """
    first, end = scene.part_start[i], scene.part_start[i + 1]
    if partner >= 0:
        a, b = first, scene.part_start[partner]
        a1, b1 = end, scene.part_start[partner + 1]
        xa, ya, ca, sa = x, y, c, s
        xb, yb = others_at[partner, SPOT_X], others_at[partner, SPOT_Y]
        cb, sb = others_at[partner, SPOT_C], others_at[partner, SPOT_S]
        # Asked from either side the answer must be one: the lower key comes first.
        swapped = scene.marks[KEY, i] > scene.marks[KEY, partner]
        if swapped:
            a, b, a1, b1 = b, a, b1, a1
            xa, ya, ca, sa, xb, yb, cb, sb = xb, yb, cb, sb, xa, ya, ca, sa
        depth, nx, ny, part_a, part_b, px, py = body_contact(scene.parts, a, a1, xa, ya, ca, sa, b, b1, xb, yb, cb, sb)
        if swapped:
            return depth, -nx, -ny, part_b - b, part_a - a, px, py
        return depth, nx, ny, part_a - a, part_b - b, px, py
    piece = A_WALL - partner
    best = -np.inf
    normal_x = normal_y = px = py = 0.0
    part = first
    for p in range(first, end):
        if max(scene.parts[p, BOTTOM], scene.pieces[piece, PIECE_BOTTOM]) >= min(
            scene.parts[p, TOP], scene.pieces[piece, PIECE_TOP]
        ):
            continue
        depth, nx, ny, qx, qy = piece_contact(
            scene.links, scene.edges, piece,
            x + (c * scene.parts[p, PART_X] - s * scene.parts[p, PART_Y]),
            y + (s * scene.parts[p, PART_X] + c * scene.parts[p, PART_Y]),
            c, s, scene.parts[p, HALF_LENGTH], scene.parts[p, HALF_WIDTH],
        )  # fmt: skip
        if depth > best:
            best, normal_x, normal_y, part, px, py = depth, nx, ny, p, qx, qy
    return best, normal_x, normal_y, part - first, 0, px, py


# ---------------------------------------------------------------- what may stand


@njit(cache=True, error_model="numpy")
def _allowed(new: float, old: float, licence: float) -> tuple[float, float]:
    """Return by how much a depth is more than may stand, and how far to leave to be as deep as it was."""
    if old > TOLERANCE:
        limit = max(old, licence)
        return new - limit, new - limit
    return new - TOLERANCE, new - old


@njit(cache=True, error_model="numpy")
def wall_excess(scene: Scene, i: int, x: float, y: float, c: float, s: float) -> tuple[float, float, int]:
    """Return by how much body i is too deep in a wall, m, not above 0 if it may stand.

    Args:
        scene: The scene.
        i: The body.
        x: Where it would be.
        y: Where it would be.
        c: Cosine of its heading.
        s: Sine of its heading.

    Returns:
        The excess; how far to leave, m; the partner.
    """
    new, piece = _wall_depth(scene, i, x, y, c, s, TOLERANCE)
    if piece < 0:
        return 0.0, 0.0, NOBODY
    at = scene.old
    old, _ = _wall_depth(scene, i, at[i, SPOT_X], at[i, SPOT_Y], at[i, SPOT_C], at[i, SPOT_S], 0.0)
    excess, leave = _allowed(new, old, scene.licence[i])
    return excess, leave, A_WALL - piece


@njit(cache=True, error_model="numpy")
def body_excess(
    scene: Scene, i: int, x: float, y: float, c: float, s: float, others_at: Floats, j: int
) -> tuple[float, float]:
    """Return by how much body i is too deep in body j, m, not above 0 if it may stand; and how far to leave, m."""
    dx, dy = others_at[j, SPOT_X] - x, others_at[j, SPOT_Y] - y
    reach = scene.shape[RADIUS, i] + scene.shape[RADIUS, j]
    if dx * dx + dy * dy > reach * reach:
        return 0.0, 0.0
    new = body_depth(
        scene.parts, scene.part_start[i], scene.part_start[i + 1], x, y, c, s,
        scene.parts, scene.part_start[j], scene.part_start[j + 1],
        others_at[j, SPOT_X], others_at[j, SPOT_Y], others_at[j, SPOT_C], others_at[j, SPOT_S], TOLERANCE,
    )  # fmt: skip
    if new <= TOLERANCE:
        return 0.0, 0.0
    old = spot_depth(scene, scene.old, i, scene.old, j, 0.0)
    return _allowed(new, old, max(scene.licence[i], scene.licence[j]))


@njit(cache=True, error_model="numpy")
def may_stand(scene: Scene, at: Floats, i: int, others_at: Floats, j: int) -> bool:
    """Return whether body i at its spot may stand against body j at its."""
    return body_excess(scene, i, at[i, SPOT_X], at[i, SPOT_Y], at[i, SPOT_C], at[i, SPOT_S], others_at, j)[0] <= 0.0


@njit(cache=True, error_model="numpy")
def _worst(scene: Scene, i: int, x: float, y: float, c: float, s: float, any_will_do: bool) -> tuple[float, float, int]:
    """Return by how much body i is too deep in what it is too deep in most: others are where `ref` says.

    Returns:
        The excess, m, 0 if the pose may stand; how far to leave, m; the partner. Of equals a wall counts first, then
        the lower key. If `any_will_do`, the first that is too deep.
    """
    excess, leave, partner = wall_excess(scene, i, x, y, c, s)
    if excess <= 0.0:
        excess, partner = 0.0, NOBODY
    for k in range(scene.near_start[i], scene.near_start[i + 1]):
        if any_will_do and excess > 0.0:
            break
        j = scene.near[k]
        over, away = body_excess(scene, i, x, y, c, s, scene.ref, j)
        if over > excess or (
            over > 0.0 and over == excess and partner >= 0 and scene.marks[KEY, j] < scene.marks[KEY, partner]
        ):
            excess, leave, partner = over, away, j
    return excess, leave, partner


@njit(cache=True, error_model="numpy")
def slide(scene: Scene, i: int, x: float, y: float, c: float, s: float, most: float) -> tuple[bool, float, float]:
    """Move body i out of what it is too deep in, along the normals, without turning.

    Args:
        scene: The scene.
        i: The body.
        x: Where it would be.
        y: Where it would be.
        c: Cosine of its heading.
        s: Sine of its heading.
        most: How far it may be moved in all, m; 0 only asks whether it may stand.

    Returns:
        Whether it then may stand, and where.
    """
    moved = 0.0
    for push in range(_MOST_PUSHES + 1):
        last = push == _MOST_PUSHES or most <= 0.0
        excess, leave, partner = _worst(scene, i, x, y, c, s, last)
        if excess <= 0.0:
            return True, x, y
        leave += _CLEARANCE
        moved += leave
        if last or moved > most:
            break
        _, nx, ny, _, _, _, _ = contact_of(scene, i, x, y, c, s, partner, scene.ref)
        x += leave * nx
        y += leave * ny
    return False, x, y
