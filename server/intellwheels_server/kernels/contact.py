"""Contact: what becomes of the arcs that bodies want to drive when something is in the way.

Nobody pushes anybody. All bodies propose, those whose proposals may not stand are found together, and each of them
then looks for the best it can do alone. Nothing here depends on the order of bodies in the arrays: every
decision is a largest, a least or an any, with ties broken by wall index and key.

A pose may stand if against every partner the depth is at most what it was at the start of the sub-step, or
`TOLERANCE`. What was put into something (spawned, teleported, reported by a real chair) has a licence: the depth it
then had. Where it overlapped before, it may be as deep as that, until it overlaps nothing any more. So it can leave.

Words: m = |travel| + |turn| r bounds how far any point of a body moves in the tick, r being its farthest corner. A
partner is what a body could meet: within circles of r + |travel| + m. An island is a set of movers connected by
partnership. `free` is who still got every proposal of the tick; `stay` who did not get the present one.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from intellwheels_server.kernels.arrays import (
    ANCHORED, BLOCKED, BOTTOM, CELL, COLLISION, CONTACT, END_HEADING, END_X, END_Y, FORWARD, HALF_LENGTH, HALF_WIDTH,
    HEADING, HELD, HIGHEST, HIT_BODY, HIT_CLOSING, HIT_DEPTH, HIT_NORMAL_X, HIT_NORMAL_Y, HIT_OTHER, HIT_OTHER_PART,
    HIT_PART, HIT_WALL, HIT_WHO, HIT_X, HIT_Y, KEY, LICENCE, LOWEST, ORIGIN_X, ORIGIN_Y, PART_X, PART_Y, PIECE_BOTTOM,
    PIECE_THICKNESS, PIECE_TOP, PIECE_X0, PIECE_X1, PIECE_Y0, PIECE_Y1, RADIUS, STALLED, THICKNESS, TOP, TRAVEL, TURN,
    TURNED, WALL, Floats, Ints, X, Y,
)  # fmt: skip
from intellwheels_server.kernels.elementary import sincos
from intellwheels_server.kernels.geometry import arc, body_contact, body_depth, piece_contact, piece_depth
from intellwheels_server.kernels.grid import cell_of, fill_cells

# Depth up to which things touch and do not overlap, m: a thousand times the rounding of a floor of 10 km.
TOLERANCE = 1e-9

# Longest step, m: a body that slides along a wall leaves it by less than this times the turn.
_LONGEST_STEP = 0.02
# Sub-steps a tick at most, since a turn's lot is drawn by 1024 tick + sub-step. Reached by no
# body of sane size: at 3 m/s and 20 Hz it would need parts of 0.3 mm.
_MOST_STEPS = 1023

# A body pushed out of what it meets lands this much farther, m, so that rounding leaves it outside.
_CLEARANCE = 1e-12
_MOST_PUSHES = 8
_HALVINGS = 12

# Wheels stall when less than this share of the wanted motion came about.
_STALL_SHARE = 0.02

# Where part of the answer has no owner.
NOBODY = -1
A_WALL = -2

# Columns of a spot block, float64[n, 5]: a pose and the cosine and sine of its heading.
_X, _Y, _H, _C, _S = 0, 1, 2, 3, 4

# Columns of the reach block, float64[n, 3]: m; r + |travel| + m; r + |travel|.
_MOTION, _WIDE, _SURE = 0, 1, 2


class _Scene(NamedTuple):
    """What the functions of one tick look at, and never change but `old` and `ref`.

    `old` is where everybody is at the start of the sub-step, `ref` where the others see them. `near` holds the
    partners of each body, between `near_start[i]` and the next; `walls` its wall pieces.
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


# ---------------------------------------------------------------- depths


@njit(cache=True, error_model="numpy")
def _pair_depth(
    scene: _Scene,
    i: int,
    xi: float,
    yi: float,
    ci: float,
    si: float,
    j: int,
    xj: float,
    yj: float,
    cj: float,
    sj: float,
    floor: float,
) -> float:
    return body_depth(
        scene.parts,
        scene.part_start[i],
        scene.part_start[i + 1],
        xi,
        yi,
        ci,
        si,
        scene.parts,
        scene.part_start[j],
        scene.part_start[j + 1],
        xj,
        yj,
        cj,
        sj,
        floor,
    )


@njit(cache=True, error_model="numpy")
def _apart(scene: _Scene, i: int, xi: float, yi: float, j: int, xj: float, yj: float) -> bool:
    """Return whether two bodies' circles are apart, so that they cannot overlap."""
    dx, dy = xj - xi, yj - yi
    reach = scene.shape[RADIUS, i] + scene.shape[RADIUS, j]
    return dx * dx + dy * dy > reach * reach


@njit(cache=True, error_model="numpy")
def _spot_depth(scene: _Scene, at: Floats, i: int, others_at: Floats, j: int, floor: float) -> float:
    """Return how deep body i at its spot overlaps body j at its, m, or the floor."""
    return _pair_depth(
        scene,
        i,
        at[i, _X],
        at[i, _Y],
        at[i, _C],
        at[i, _S],
        j,
        others_at[j, _X],
        others_at[j, _Y],
        others_at[j, _C],
        others_at[j, _S],
        floor,
    )


@njit(cache=True, error_model="numpy")
def _piece_apart(pieces: Floats, piece: int, x: float, y: float, radius: float) -> bool:
    dx = max(pieces[piece, PIECE_X0] - x, x - pieces[piece, PIECE_X1])
    dx = max(dx, 0.0)
    dy = max(pieces[piece, PIECE_Y0] - y, y - pieces[piece, PIECE_Y1])
    dy = max(dy, 0.0)
    return dx * dx + dy * dy > radius * radius


@njit(cache=True, error_model="numpy")
def _one_piece_depth(
    parts: Floats,
    part0: int,
    part1: int,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    piece: int,
    x: float,
    y: float,
    c: float,
    s: float,
    floor: float,
) -> float:
    """Return how deep any part of a body overlaps a wall piece, m, or the floor."""
    for p in range(part0, part1):
        if max(parts[p, BOTTOM], pieces[piece, PIECE_BOTTOM]) < min(parts[p, TOP], pieces[piece, PIECE_TOP]):
            floor = piece_depth(
                links,
                edges,
                piece,
                x + (c * parts[p, PART_X] - s * parts[p, PART_Y]),
                y + (s * parts[p, PART_X] + c * parts[p, PART_Y]),
                c,
                s,
                parts[p, HALF_LENGTH],
                parts[p, HALF_WIDTH],
                floor,
            )
    return floor


@njit(cache=True, error_model="numpy")
def _wall_depth(scene: _Scene, i: int, x: float, y: float, c: float, s: float, floor: float) -> tuple[float, int]:
    """Return how deep body i overlaps any wall, m, or the floor, and the deepest piece: of equals the first.

    A body's candidates are sorted, so the first is that of the lowest wall.
    """
    deepest = NOBODY
    radius = scene.shape[RADIUS, i]
    for k in range(scene.wall_start[i], scene.wall_start[i + 1]):
        piece = scene.walls[k]
        if _piece_apart(scene.pieces, piece, x, y, radius):
            continue
        depth = _one_piece_depth(
            scene.parts,
            scene.part_start[i],
            scene.part_start[i + 1],
            scene.pieces,
            scene.links,
            scene.edges,
            piece,
            x,
            y,
            c,
            s,
            floor,
        )
        if depth > floor:
            floor, deepest = depth, piece
    return floor, deepest


@njit(cache=True, error_model="numpy")
def _wall_contact(
    scene: _Scene, i: int, piece: int, x: float, y: float, c: float, s: float
) -> tuple[float, float, float, int, float, float]:
    """Return where body i meets a wall piece: depth, normal (x, y), part, point (x, y)."""
    best = -np.inf
    normal_x = normal_y = px = py = 0.0
    part = scene.part_start[i]
    for p in range(scene.part_start[i], scene.part_start[i + 1]):
        if max(scene.parts[p, BOTTOM], scene.pieces[piece, PIECE_BOTTOM]) >= min(
            scene.parts[p, TOP], scene.pieces[piece, PIECE_TOP]
        ):
            continue
        depth, nx, ny, qx, qy = piece_contact(
            scene.links,
            scene.edges,
            piece,
            x + (c * scene.parts[p, PART_X] - s * scene.parts[p, PART_Y]),
            y + (s * scene.parts[p, PART_X] + c * scene.parts[p, PART_Y]),
            c,
            s,
            scene.parts[p, HALF_LENGTH],
            scene.parts[p, HALF_WIDTH],
        )
        if depth > best:
            best, normal_x, normal_y, part, px, py = depth, nx, ny, p, qx, qy
    return best, normal_x, normal_y, part, px, py


@njit(cache=True, error_model="numpy")
def _pair_contact(
    scene: _Scene,
    i: int,
    xi: float,
    yi: float,
    ci: float,
    si: float,
    j: int,
    xj: float,
    yj: float,
    cj: float,
    sj: float,
) -> tuple[float, float, float, int, int, float, float]:
    """Return where two bodies meet: depth, normal along which i leaves j, part of i, part of j, point."""
    start = scene.part_start
    if scene.marks[KEY, i] < scene.marks[KEY, j]:
        return body_contact(scene.parts, start[i], start[i + 1], xi, yi, ci, si, start[j], start[j + 1], xj, yj, cj, sj)
    depth, nx, ny, part_j, part_i, px, py = body_contact(
        scene.parts, start[j], start[j + 1], xj, yj, cj, sj, start[i], start[i + 1], xi, yi, ci, si
    )
    return depth, -nx, -ny, part_i, part_j, px, py


# ---------------------------------------------------------------- what may stand


@njit(cache=True, error_model="numpy")
def _limit(old: float, licence: float) -> float:
    """Return the depth that may stand where it was `old` at the start of the sub-step."""
    return max(old, licence) if old > TOLERANCE else TOLERANCE


@njit(cache=True, error_model="numpy")
def _may_not_stand(scene: _Scene, at: Floats, i: int, others_at: Floats, j: int) -> bool:
    """Return whether body i at its spot is too deep in body j at its."""
    if _apart(scene, i, at[i, _X], at[i, _Y], j, others_at[j, _X], others_at[j, _Y]):
        return False
    new = _spot_depth(scene, at, i, others_at, j, TOLERANCE)
    if new <= TOLERANCE:
        return False
    old = _spot_depth(scene, scene.old, i, scene.old, j, 0.0)
    return new > _limit(old, max(scene.licence[i], scene.licence[j]))


@njit(cache=True, error_model="numpy")
def _worst(
    scene: _Scene, i: int, x: float, y: float, c: float, s: float, any_will_do: bool
) -> tuple[float, float, int, int]:
    """Return by how much body i is too deep in what it is too deep in most.

    Args:
        scene: The scene; others are where `ref` says.
        i: The body.
        x: Its pose.
        y: Its pose.
        c: Cosine of its heading.
        s: Sine of its heading.
        any_will_do: Stop at the first that is too deep.

    Returns:
        The excess, m, 0 if the pose may stand; by how far it has to leave, m; the partner, `A_WALL` or
        `NOBODY`; the wall piece.
    """
    excess = 0.0
    leave = 0.0
    partner = NOBODY
    piece = NOBODY
    new, deepest = _wall_depth(scene, i, x, y, c, s, TOLERANCE)
    if new > TOLERANCE:
        old, _ = _wall_depth(scene, i, scene.old[i, _X], scene.old[i, _Y], scene.old[i, _C], scene.old[i, _S], 0.0)
        limit = _limit(old, scene.licence[i])
        if new > limit:
            excess = new - limit
            leave = new - (limit if old > TOLERANCE else old)
            partner, piece = A_WALL, deepest
            if any_will_do:
                return excess, leave, partner, piece
    for k in range(scene.near_start[i], scene.near_start[i + 1]):
        j = scene.near[k]
        if _apart(scene, i, x, y, j, scene.ref[j, _X], scene.ref[j, _Y]):
            continue
        new = _pair_depth(
            scene, i, x, y, c, s, j, scene.ref[j, _X], scene.ref[j, _Y], scene.ref[j, _C], scene.ref[j, _S], TOLERANCE
        )
        if new <= TOLERANCE:
            continue
        old = _spot_depth(scene, scene.old, i, scene.old, j, 0.0)
        limit = _limit(old, max(scene.licence[i], scene.licence[j]))
        if new <= limit:
            continue
        over = new - limit
        if over > excess or (over == excess and partner >= 0 and scene.marks[KEY, j] < scene.marks[KEY, partner]):
            excess = over
            leave = new - (limit if old > TOLERANCE else old)
            partner = j
            if any_will_do:
                break
    return excess, leave, partner, piece


@njit(cache=True, error_model="numpy")
def _slide(scene: _Scene, i: int, x: float, y: float, c: float, s: float, most: float) -> tuple[bool, float, float]:
    """Move body i out of what it is too deep in, along the normals, without turning.

    Args:
        scene: The scene.
        i: The body.
        x: Where it would be.
        y: Where it would be.
        c: Cosine of its heading.
        s: Sine of its heading.
        most: How far it may be moved in all, m.

    Returns:
        Whether it then may stand, and where.
    """
    moved = 0.0
    for push in range(_MOST_PUSHES + 1):
        excess, leave, partner, piece = _worst(scene, i, x, y, c, s, push == _MOST_PUSHES)
        if excess <= 0.0:
            return True, x, y
        leave += _CLEARANCE
        moved += leave
        if moved > most or push == _MOST_PUSHES:
            break
        if partner == A_WALL:
            _, nx, ny, _, _, _ = _wall_contact(scene, i, piece, x, y, c, s)
        else:
            _, nx, ny, _, _, _, _ = _pair_contact(
                scene,
                i,
                x,
                y,
                c,
                s,
                partner,
                scene.ref[partner, _X],
                scene.ref[partner, _Y],
                scene.ref[partner, _C],
                scene.ref[partner, _S],
            )
        x += leave * nx
        y += leave * ny
    return False, x, y


@njit(cache=True, error_model="numpy")
def _stands(scene: _Scene, i: int, x: float, y: float, c: float, s: float) -> bool:
    return _worst(scene, i, x, y, c, s, True)[0] <= 0.0


@njit(cache=True, error_model="numpy")
def _alone(
    scene: _Scene, i: int, proposal: Floats, travel: float, turn: float, most: float, result: Floats
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
    if _stands(scene, i, proposal[i, _X], proposal[i, _Y], proposal[i, _C], proposal[i, _S]):
        for k in range(5):
            result[i, k] = proposal[i, k]
        return True, travel, turn
    x0, y0, h0 = scene.old[i, _X], scene.old[i, _Y], scene.old[i, _H]
    if scene.marks[ANCHORED, i] == 0:
        x, y, h, c, s = arc(x0, y0, h0, travel, turn)
        found, px, py = _slide(scene, i, x, y, c, s, most)
        if found:
            result[i, _X], result[i, _Y], result[i, _H], result[i, _C], result[i, _S] = px, py, h, c, s
            return False, travel + ((px - x) * c + (py - y) * s), turn
        # Without travel, or without turn, the next two are to stand still: the share found below is at least that.
        if travel != 0.0:
            x, y, h, c, s = arc(x0, y0, h0, travel, 0.0)
            found, px, py = _slide(scene, i, x, y, c, s, abs(travel))
            if found:
                result[i, _X], result[i, _Y], result[i, _H], result[i, _C], result[i, _S] = px, py, h, c, s
                return False, travel + ((px - x) * c + (py - y) * s), 0.0
        if turn != 0.0:
            x, y, h, c, s = arc(x0, y0, h0, 0.0, turn)
            if _stands(scene, i, x, y, c, s):
                result[i, _X], result[i, _Y], result[i, _H], result[i, _C], result[i, _S] = x, y, h, c, s
                return False, 0.0, turn
    low, high = 0.0, 1.0
    for k in range(5):
        result[i, k] = scene.old[i, k]
    for _ in range(_HALVINGS):
        share = 0.5 * (low + high)
        x, y, h, c, s = arc(x0, y0, h0, share * travel, share * turn)
        if _stands(scene, i, x, y, c, s):
            low = share
            result[i, _X], result[i, _Y], result[i, _H], result[i, _C], result[i, _S] = x, y, h, c, s
        else:
            high = share
    return False, low * travel, low * turn


@njit(cache=True, error_model="numpy")
def lot(key: int, tick: int, step: int) -> int:
    """Return a body's turn in a sub-step: of two whose ways conflict, the smaller goes back.

    Args:
        key: Of the body's name.
        tick: Which tick.
        step: Which sub-step, from 0.

    Returns:
        64 bits as an unsigned integer.

    Source:
        Steele, Lea, Flood, Fast splittable pseudorandom number generators, 2014 (SplitMix64).
    """
    count = np.uint64(1024) * np.uint64(tick) + np.uint64(step) + np.uint64(1)
    z = np.uint64(key) + np.uint64(0x9E3779B97F4A7C15) * count
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))  # type: ignore[return-value]


# ---------------------------------------------------------------- who could meet whom


@njit(cache=True, error_model="numpy")
def _grown(items: Ints, used: int) -> Ints:
    """Return the items with room for more."""
    larger = np.empty(2 * items.shape[0] + 16, dtype=np.int64)
    for k in range(used):
        larger[k] = items[k]
    return larger


@njit(cache=True, error_model="numpy")
def _pieces_near(
    pieces: Floats,
    cells: Ints,
    frame: Floats,
    x: float,
    y: float,
    reach: float,
    low: float,
    high: float,
    items: Ints,
    used: int,
) -> tuple[Ints, int]:
    """Append the wall pieces that meet a circle and share z with [low, high); return the items and how many."""
    columns, rows = cells[0], cells[1]
    size = frame[CELL]
    c0 = cell_of(x - reach, frame[ORIGIN_X], size, columns)
    c1 = cell_of(x + reach, frame[ORIGIN_X], size, columns)
    r0 = cell_of(y - reach, frame[ORIGIN_Y], size, rows)
    r1 = cell_of(y + reach, frame[ORIGIN_Y], size, rows)
    for row in range(r0, r1 + 1):
        for column in range(c0, c1 + 1):
            at = 2 + row * columns + column
            for k in range(cells[at], cells[at + 1]):
                piece = cells[k]
                if max(pieces[piece, PIECE_BOTTOM], low) >= min(pieces[piece, PIECE_TOP], high):
                    continue
                if _piece_apart(pieces, piece, x, y, reach):
                    continue
                if (
                    max(cell_of(pieces[piece, PIECE_X0], frame[ORIGIN_X], size, columns), c0) != column
                    or max(cell_of(pieces[piece, PIECE_Y0], frame[ORIGIN_Y], size, rows), r0) != row
                ):
                    continue
                if used == items.shape[0]:
                    items = _grown(items, used)
                items[used] = piece
                used += 1
    return items, used


@njit(cache=True, error_model="numpy")
def _meet(pose: Floats, reach: Floats, measure: int, i: int, j: int) -> bool:
    dx, dy = pose[X, j] - pose[X, i], pose[Y, j] - pose[Y, i]
    both = reach[i, measure] + reach[j, measure]
    return dx * dx + dy * dy < both * both


@njit(cache=True, error_model="numpy")
def _pairs_near(shape: Floats, pose: Floats, reach: Floats) -> tuple[Ints, Ints, int]:
    """Return the pairs (i, j), i < j, of bodies of which one moves and that are partners: firsts, seconds, how many."""
    n = pose.shape[1]
    first = np.empty(4 * n + 16, dtype=np.int64)
    second = np.empty(4 * n + 16, dtype=np.int64)
    used = 0
    if n < 12:
        # Cheaper than a grid.
        for i in range(n):
            for j in range(i + 1, n):
                if (
                    (reach[i, _MOTION] > 0.0 or reach[j, _MOTION] > 0.0)
                    and _meet(pose, reach, _WIDE, i, j)
                    and max(shape[LOWEST, i], shape[LOWEST, j]) < min(shape[HIGHEST, i], shape[HIGHEST, j])
                ):
                    if used == first.shape[0]:
                        first, second = _grown(first, used), _grown(second, used)
                    first[used], second[used] = i, j
                    used += 1
        return first, second, used
    boxes = np.empty((n, 4))
    x0 = y0 = np.inf
    x1 = y1 = -np.inf
    widest = 0.0
    for i in range(n):
        wide = reach[i, _WIDE]
        boxes[i, 0], boxes[i, 1] = pose[X, i] - wide, pose[Y, i] - wide
        boxes[i, 2], boxes[i, 3] = pose[X, i] + wide, pose[Y, i] + wide
        x0, y0 = min(x0, boxes[i, 0]), min(y0, boxes[i, 1])
        x1, y1 = max(x1, boxes[i, 2]), max(y1, boxes[i, 3])
        widest = max(widest, wide)
    # As wide as a chair, unless somebody is much larger or they stand far apart. The answer does not depend on it.
    size = max(min(2.0 * widest, 2.0), widest / 8.0)
    while ((x1 - x0) / size + 1.0) * ((y1 - y0) / size + 1.0) > 8.0 * n:
        size *= 1.5
    columns, rows = int((x1 - x0) / size) + 1, int((y1 - y0) / size) + 1
    cells = fill_cells(boxes, x0, y0, size, columns, rows)
    home = np.empty((n, 2), dtype=np.int64)
    for i in range(n):
        home[i, 0] = cell_of(boxes[i, 0], x0, size, columns)
        home[i, 1] = cell_of(boxes[i, 1], y0, size, rows)
    for i in range(n):
        if reach[i, _MOTION] <= 0.0:
            continue
        for row in range(home[i, 1], cell_of(boxes[i, 3], y0, size, rows) + 1):
            for column in range(home[i, 0], cell_of(boxes[i, 2], x0, size, columns) + 1):
                at = 2 + row * columns + column
                for k in range(cells[at], cells[at + 1]):
                    j = cells[k]
                    if j == i or (j < i and reach[j, _MOTION] > 0.0):
                        continue
                    if max(home[j, 0], home[i, 0]) != column or max(home[j, 1], home[i, 1]) != row:
                        continue
                    if not _meet(pose, reach, _WIDE, i, j):
                        continue
                    if max(shape[LOWEST, i], shape[LOWEST, j]) >= min(shape[HIGHEST, i], shape[HIGHEST, j]):
                        continue
                    if used == first.shape[0]:
                        first, second = _grown(first, used), _grown(second, used)
                    first[used], second[used] = min(i, j), max(i, j)
                    used += 1
    return first, second, used


@njit(cache=True, error_model="numpy")
def _root(parent: Ints, i: int) -> int:
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


# ---------------------------------------------------------------- the tick


@njit(cache=True, error_model="numpy")
def _put_down(
    scene: _Scene,
    hits: Ints,
    hit_numbers: Floats,
    used: int,
    twist: Floats,
    i: int,
    j: int,
    piece: int,
    at: Floats,
    who: int,
) -> int:
    """Write down that i met j, or a wall piece, if there is room; return how many there are now."""
    if used < hits.shape[0]:
        closing_x = twist[TRAVEL, i] * scene.old[i, _C]
        closing_y = twist[TRAVEL, i] * scene.old[i, _S]
        if j >= 0:
            depth, nx, ny, part, other_part, px, py = _pair_contact(
                scene,
                i,
                at[i, _X],
                at[i, _Y],
                at[i, _C],
                at[i, _S],
                j,
                scene.ref[j, _X],
                scene.ref[j, _Y],
                scene.ref[j, _C],
                scene.ref[j, _S],
            )
            other_part -= scene.part_start[j]
            wall = NOBODY
            closing_x -= twist[TRAVEL, j] * scene.old[j, _C] - twist[TURN, j] * (py - scene.old[j, _Y])
            closing_y -= twist[TRAVEL, j] * scene.old[j, _S] + twist[TURN, j] * (px - scene.old[j, _X])
        else:
            depth, nx, ny, part, px, py = _wall_contact(scene, i, piece, at[i, _X], at[i, _Y], at[i, _C], at[i, _S])
            wall = scene.links[piece, WALL]
            other_part = piece
        closing_x -= twist[TURN, i] * (py - scene.old[i, _Y])
        closing_y += twist[TURN, i] * (px - scene.old[i, _X])
        hits[used, HIT_BODY], hits[used, HIT_OTHER], hits[used, HIT_WALL] = i, j, wall
        hits[used, HIT_PART], hits[used, HIT_OTHER_PART] = part - scene.part_start[i], other_part
        hits[used, HIT_WHO] = who
        hit_numbers[used, HIT_X], hit_numbers[used, HIT_Y] = px, py
        hit_numbers[used, HIT_NORMAL_X], hit_numbers[used, HIT_NORMAL_Y] = nx, ny
        hit_numbers[used, HIT_DEPTH] = depth
        hit_numbers[used, HIT_CLOSING] = -(closing_x * nx + closing_y * ny)
    return used + 1


@njit(cache=True, error_model="numpy")
def _who_collides(scene: _Scene, proposal: Floats, i: int, j: int) -> int:
    """Return 1 if i alone, by its proposal, comes deeper into (or nearer to) j than it was; 0 if not."""
    was = _spot_depth(scene, scene.old, i, scene.old, j, -np.inf)
    would = _spot_depth(scene, proposal, i, scene.old, j, -np.inf)
    return 1 if would > was + TOLERANCE else 0


@njit(cache=True, error_model="numpy")
def _settle(
    scene: _Scene,
    members: Ints,
    steps: int,
    tick: int,
    pose: Floats,
    twist: Floats,
    reach: Floats,
    near_edge: Ints,
    edge_hit: Ints,
    outcome: Floats,
    flags: Ints,
    hits: Ints,
    hit_numbers: Floats,
    used: int,
    proposal: Floats,
    result: Floats,
    status: Ints,
    gain: Floats,
) -> int:
    """Move the members of one island through their sub-steps; return how many hits there are now.

    `status` has rows: free; stay; noted; got (its proposal, after all); back (loses to another's result).
    `gain` has rows: forward travel and turn of the sub-step.
    """
    free, stay, noted, got, back = 0, 1, 2, 3, 4
    count = members.shape[0]
    queue = np.empty(2 * count, dtype=np.int64)
    for i in members:
        status[free, i] = 1
        status[noted, i] = 0
    for step in range(steps):
        share = (step + 1) / steps
        for i in members:
            d, a = twist[TRAVEL, i], twist[TURN, i]
            if status[free, i] != 0:
                x, y, h, c, s = arc(pose[X, i], pose[Y, i], pose[HEADING, i], share * d, share * a)
            else:
                x, y, h, c, s = arc(scene.old[i, _X], scene.old[i, _Y], scene.old[i, _H], d / steps, a / steps)
            proposal[i, _X], proposal[i, _Y], proposal[i, _H], proposal[i, _C], proposal[i, _S] = x, y, h, c, s
            for k in range(5):
                scene.ref[i, k] = proposal[i, k]
            status[stay, i] = 0
        # The first round: everybody at proposals.
        fresh = 0
        for i in members:
            depth, piece = _wall_depth(
                scene, i, proposal[i, _X], proposal[i, _Y], proposal[i, _C], proposal[i, _S], TOLERANCE
            )
            if depth > TOLERANCE:
                old, _ = _wall_depth(
                    scene, i, scene.old[i, _X], scene.old[i, _Y], scene.old[i, _C], scene.old[i, _S], 0.0
                )
                if depth > _limit(old, scene.licence[i]):
                    if status[noted, i] == 0:
                        status[noted, i] = 1
                        queue[fresh] = i
                        fresh += 1
                    if flags[COLLISION, i] & 2 == 0:
                        # The second bit says that the wall was written down.
                        flags[COLLISION, i] |= 3
                        flags[CONTACT, i] = 1
                        used = _put_down(scene, hits, hit_numbers, used, twist, i, A_WALL, piece, proposal, 1)
            for k in range(scene.near_start[i], scene.near_start[i + 1]):
                j = scene.near[k]
                both = reach[j, _MOTION] > 0.0
                if (both and j < i) or not _may_not_stand(scene, proposal, i, scene.ref, j):
                    continue
                if status[noted, i] == 0:
                    status[noted, i] = 1
                    queue[fresh] = i
                    fresh += 1
                who = _who_collides(scene, proposal, i, j)
                if both:
                    if status[noted, j] == 0:
                        status[noted, j] = 1
                        queue[fresh] = j
                        fresh += 1
                    who += 2 * _who_collides(scene, proposal, j, i)
                used = _hit(scene, hits, hit_numbers, used, twist, i, j, proposal, who, edge_hit, near_edge[k], flags)
        first = 0
        while first < fresh:
            for k in range(first, fresh):
                i = queue[k]
                status[stay, i] = 1
                for m in range(5):
                    scene.ref[i, m] = scene.old[i, m]
            last = fresh
            for q in range(first, last):
                j = queue[q]
                for k in range(scene.near_start[j], scene.near_start[j + 1]):
                    i = scene.near[k]
                    if reach[i, _MOTION] <= 0.0 or status[stay, i] != 0:
                        continue
                    if not _may_not_stand(scene, proposal, i, scene.old, j):
                        continue
                    if status[noted, i] == 0:
                        status[noted, i] = 1
                        queue[fresh] = i
                        fresh += 1
                    who = _who_collides(scene, proposal, i, j)
                    used = _hit(
                        scene, hits, hit_numbers, used, twist, i, j, proposal, who, edge_hit, near_edge[k], flags
                    )
            first = last
        # What each of those who stay can do alone.
        for q in range(fresh):
            i = queue[q]
            d, a = twist[TRAVEL, i] / steps, twist[TURN, i] / steps
            taken, gain[0, i], gain[1, i] = _alone(scene, i, proposal, d, a, reach[i, _MOTION] / steps, result)
            status[got, i] = 1 if taken else 0
            status[back, i] = 0
        for q in range(fresh):
            i = queue[q]
            for k in range(scene.near_start[i], scene.near_start[i + 1]):
                j = scene.near[k]
                if j < i or status[stay, j] == 0 or reach[j, _MOTION] <= 0.0:
                    continue
                if not _may_not_stand(scene, result, i, result, j):
                    continue
                turn_i = lot(scene.marks[KEY, i], tick, step)
                turn_j = lot(scene.marks[KEY, j], tick, step)
                if turn_i < turn_j or (turn_i == turn_j and scene.marks[KEY, i] > scene.marks[KEY, j]):
                    status[back, i] = 1
                else:
                    status[back, j] = 1
        for i in members:
            if status[stay, i] == 0:
                outcome[FORWARD, i] += twist[TRAVEL, i] / steps
                outcome[TURNED, i] += twist[TURN, i] / steps
                for k in range(5):
                    scene.old[i, k] = proposal[i, k]
                continue
            status[noted, i] = 0
            if status[back, i] != 0:
                status[free, i] = 0
                continue
            if status[got, i] == 0:
                status[free, i] = 0
            outcome[FORWARD, i] += gain[0, i]
            outcome[TURNED, i] += gain[1, i]
            for k in range(5):
                scene.old[i, k] = result[i, k]
        for i in members:
            for k in range(5):
                scene.ref[i, k] = scene.old[i, k]
    for i in members:
        outcome[END_X, i], outcome[END_Y, i], outcome[END_HEADING, i] = (
            scene.old[i, _X],
            scene.old[i, _Y],
            scene.old[i, _H],
        )
        flags[COLLISION, i] &= 1
        if status[free, i] != 0:
            outcome[FORWARD, i], outcome[TURNED, i] = twist[TRAVEL, i], twist[TURN, i]
            continue
        flags[BLOCKED, i] = 1
        dx, dy = outcome[END_X, i] - pose[X, i], outcome[END_Y, i] - pose[Y, i]
        achieved = np.sqrt(dx * dx + dy * dy) + abs(outcome[TURNED, i]) * scene.shape[RADIUS, i]
        if achieved < _STALL_SHARE * reach[i, _MOTION]:
            flags[STALLED, i] = 1
    return used


@njit(cache=True, error_model="numpy")
def _hit(
    scene: _Scene,
    hits: Ints,
    hit_numbers: Floats,
    used: int,
    twist: Floats,
    i: int,
    j: int,
    at: Floats,
    who: int,
    edge_hit: Ints,
    edge: int,
    flags: Ints,
) -> int:
    """Flag who collides (bit 0: i, bit 1: j) and write the pair down once a tick; return how many hits there are."""
    if who == 0:
        return used
    if who & 1:
        flags[COLLISION, i] |= 1
    if who & 2:
        flags[COLLISION, j] |= 1
    flags[CONTACT, i] = 1
    flags[CONTACT, j] = 1
    # In the hit, the lower index comes first.
    swapped = ((who & 1) << 1) | (who >> 1)
    if edge_hit[edge] < 0:
        edge_hit[edge] = used
        if i < j:
            return _put_down(scene, hits, hit_numbers, used, twist, i, j, NOBODY, at, who)
        return _put_down(scene, hits, hit_numbers, used, twist, j, i, NOBODY, scene.ref, swapped)
    known = edge_hit[edge]
    if known < hits.shape[0]:
        hits[known, HIT_WHO] |= who if i < j else swapped
    return used


@njit(cache=True, error_model="numpy")
def _sort(items: Ints, first: int, end: int) -> None:
    """Sort a short stretch in place."""
    for k in range(first + 1, end):
        item = items[k]
        at = k
        while at > first and items[at - 1] > item:
            items[at] = items[at - 1]
            at -= 1
        items[at] = item


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
    reach = np.empty((n, 3))
    movers = 0
    licensed = False
    for i in range(n):
        d, a = abs(twist[TRAVEL, i]), abs(twist[TURN, i])
        if marks[HELD, i] != 0:
            d = a = 0.0
        motion = d + a * shape[RADIUS, i]
        reach[i, _MOTION] = motion
        reach[i, _WIDE] = shape[RADIUS, i] + d + motion
        reach[i, _SURE] = shape[RADIUS, i] + d
        movers += motion > 0.0
        licensed |= licence[i] > 0.0
        outcome[END_X, i], outcome[END_Y, i], outcome[END_HEADING, i] = pose[X, i], pose[Y, i], pose[HEADING, i]
        outcome[FORWARD, i] = outcome[TURNED, i] = 0.0
        outcome[LICENCE, i] = licence[i]
        for k in range(4):
            flags[k, i] = 0
    used = 0
    if movers > 0:
        used = _move(
            parts, part_start, shape, marks, pieces, links, edges, cells, frame, pose, twist, licence, tick,
            reach, outcome, flags, hits, hit_numbers,
        )  # fmt: skip
    if licensed:
        for i in range(n):
            if licence[i] > 0.0:
                depth, _, _ = _deepest_of(
                    parts, part_start[i], part_start[i + 1], shape[RADIUS, i], shape[LOWEST, i], shape[HIGHEST, i],
                    outcome[END_X, i], outcome[END_Y, i], outcome[END_HEADING, i], i,
                    parts, part_start, shape, pieces, links, edges, cells, frame, outcome,
                )  # fmt: skip
                if depth <= TOLERANCE:
                    outcome[LICENCE, i] = 0.0
    return used


@njit(cache=True, error_model="numpy")
def _move(
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
    reach: Floats,
    outcome: Floats,
    flags: Ints,
    hits: Ints,
    hit_numbers: Floats,
) -> int:
    """Find the islands and settle each; return how many hits there are."""
    n = pose.shape[1]
    first, second, pairs = _pairs_near(shape, pose, reach)
    wall_start = np.empty(n + 1, dtype=np.int64)
    walls = np.empty(8 * n, dtype=np.int64)
    found = 0
    wall_start[0] = 0
    for i in range(n):
        if reach[i, _MOTION] > 0.0 and pieces.shape[0] > 0:
            walls, found = _pieces_near(
                pieces, cells, frame, pose[X, i], pose[Y, i], reach[i, _WIDE], shape[LOWEST, i], shape[HIGHEST, i],
                walls, found,
            )  # fmt: skip
            _sort(walls, wall_start[i], found)
        wall_start[i + 1] = found
    # Islands: the root of each, whether anything in it can be met by proposals at all, its largest m, its thinnest.
    parent = np.arange(n)
    for e in range(pairs):
        i, j = first[e], second[e]
        if reach[i, _MOTION] > 0.0 and reach[j, _MOTION] > 0.0:
            i, j = _root(parent, i), _root(parent, j)
            # The root is the least index: which of them it is does not matter to the answer.
            parent[max(i, j)] = min(i, j)
    island = np.empty((n, 3))
    tight, motion, thinnest = 0, 1, 2
    for i in range(n):
        island[i, tight] = 0.0
        island[i, motion] = 0.0
        island[i, thinnest] = 2.0 * _LONGEST_STEP
    for i in range(n):
        if reach[i, _MOTION] <= 0.0:
            continue
        root = _root(parent, i)
        parent[i] = root
        island[root, motion] = max(island[root, motion], reach[i, _MOTION])
        island[root, thinnest] = min(island[root, thinnest], shape[THICKNESS, i])
        for k in range(wall_start[i], wall_start[i + 1]):
            island[root, thinnest] = min(island[root, thinnest], pieces[walls[k], PIECE_THICKNESS])
            if not _piece_apart(pieces, walls[k], pose[X, i], pose[Y, i], reach[i, _SURE]):
                island[root, tight] = 1.0
    near_start = np.zeros(n + 1, dtype=np.int64)
    for e in range(pairs):
        i, j = first[e], second[e]
        near_start[i + 1] += 1
        near_start[j + 1] += 1
        close = _meet(pose, reach, _SURE, i, j)
        for k in (i, j):
            if reach[k, _MOTION] > 0.0:
                root = parent[k]
                if close:
                    island[root, tight] = 1.0
                island[root, thinnest] = min(island[root, thinnest], shape[THICKNESS, i], shape[THICKNESS, j])
    # If no proposal can meet anything, all stand: nobody has to look.
    any_tight = False
    for i in range(n):
        if reach[i, _MOTION] <= 0.0:
            continue
        if island[parent[i], tight] != 0.0:
            any_tight = True
            continue
        d, a = twist[TRAVEL, i], twist[TURN, i]
        x, y, h, _, _ = arc(pose[X, i], pose[Y, i], pose[HEADING, i], d, a)
        outcome[END_X, i], outcome[END_Y, i], outcome[END_HEADING, i] = x, y, h
        outcome[FORWARD, i], outcome[TURNED, i] = d, a
    if not any_tight:
        return 0
    for i in range(n):
        near_start[i + 1] += near_start[i]
    near = np.empty(2 * pairs, dtype=np.int64)
    near_edge = np.empty(2 * pairs, dtype=np.int64)
    edge_hit = np.full(pairs, -1, dtype=np.int64)
    place = near_start.copy()
    for e in range(pairs):
        i, j = first[e], second[e]
        near[place[i]], near_edge[place[i]] = j, e
        place[i] += 1
        near[place[j]], near_edge[place[j]] = i, e
        place[j] += 1
    old = np.empty((n, 5))
    for i in range(n):
        s, c = sincos(pose[HEADING, i])
        old[i, _X], old[i, _Y], old[i, _H], old[i, _C], old[i, _S] = pose[X, i], pose[Y, i], pose[HEADING, i], c, s
    ref = old.copy()
    proposal = np.empty((n, 5))
    result = np.empty((n, 5))
    status = np.zeros((5, n), dtype=np.int64)
    gain = np.empty((2, n))
    scene = _Scene(
        parts, part_start, shape, marks, pieces, links, edges, licence, old, ref, near_start, near, wall_start, walls
    )
    # Members of an island are linked from its root on, ascending.
    following = np.full(n, -1, dtype=np.int64)
    last = np.arange(n)
    size = np.zeros(n, dtype=np.int64)
    for i in range(n):
        if reach[i, _MOTION] > 0.0 and island[parent[i], tight] != 0.0:
            root = parent[i]
            size[root] += 1
            if root != i:
                following[last[root]] = i
                last[root] = i
    used = 0
    members = np.empty(n, dtype=np.int64)
    for root in range(n):
        if size[root] == 0:
            continue
        i = root
        for k in range(size[root]):
            members[k] = i
            i = following[i]
        quotient = island[root, motion] / min(_LONGEST_STEP, 0.5 * island[root, thinnest])
        steps = _MOST_STEPS if quotient > _MOST_STEPS else int(np.ceil(quotient))
        used = _settle(
            scene, members[: size[root]], steps, tick, pose, twist, reach, near_edge, edge_hit, outcome, flags,
            hits, hit_numbers, used, proposal, result, status, gain,
        )  # fmt: skip
    return used


# ---------------------------------------------------------------- being put somewhere


@njit(cache=True, error_model="numpy")
def _deepest_of(
    own: Floats,
    own0: int,
    own1: int,
    radius: float,
    low: float,
    high: float,
    x: float,
    y: float,
    heading: float,
    skip: int,
    parts: Floats,
    part_start: Ints,
    shape: Floats,
    pieces: Floats,
    links: Ints,
    edges: Floats,
    cells: Ints,
    frame: Floats,
    pose: Floats,
) -> tuple[float, int, int]:
    """Return the largest depth of a body in anything, 0 if it overlaps nothing, in whom, and in which wall piece."""
    s, c = sincos(heading)
    depth = 0.0
    partner = piece = NOBODY
    if pieces.shape[0] > 0:
        items, found = _pieces_near(pieces, cells, frame, x, y, radius, low, high, np.empty(8, dtype=np.int64), 0)
        _sort(items, 0, found)
        for k in range(found):
            new = _one_piece_depth(own, own0, own1, pieces, links, edges, items[k], x, y, c, s, depth)
            if new > depth:
                depth, partner, piece = new, A_WALL, items[k]
    for j in range(part_start.shape[0] - 1):
        dx, dy = pose[X, j] - x, pose[Y, j] - y
        both = radius + shape[RADIUS, j]
        if j == skip or dx * dx + dy * dy > both * both:
            continue
        if max(low, shape[LOWEST, j]) >= min(high, shape[HIGHEST, j]):
            continue
        sj, cj = sincos(pose[HEADING, j])
        new = body_depth(
            own, own0, own1, x, y, c, s, parts, part_start[j], part_start[j + 1], pose[X, j], pose[Y, j], cj, sj, depth
        )
        if new > depth:
            depth, partner, piece = new, j, NOBODY
    return depth, partner, piece


@njit(cache=True, error_model="numpy")
def deepest(
    own: Floats,
    x: float,
    y: float,
    heading: float,
    skip: int,
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
) -> tuple[float, int, int]:
    """Return how deep a body would be in anything that is there, if it were put somewhere.

    Args:
        own: Part block of the body, which need not be among the others.
        x: Where it would be, m.
        y: Where it would be, m.
        heading: Where it would point, rad.
        skip: Its index among the bodies, -1 if it is none of them.
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

    Returns:
        The largest depth, m, 0 if it would overlap nothing (up to `TOLERANCE` is touching); the index of the body it
        is deepest in, `A_WALL` or `NOBODY`; the wall piece or -1.
    """
    radius = 0.0
    low, high = np.inf, -np.inf
    for p in range(own.shape[0]):
        dx = abs(own[p, PART_X]) + own[p, HALF_LENGTH]
        dy = abs(own[p, PART_Y]) + own[p, HALF_WIDTH]
        radius = max(radius, np.sqrt(dx * dx + dy * dy))
        low, high = min(low, own[p, BOTTOM]), max(high, own[p, TOP])
    return _deepest_of(
        own, 0, own.shape[0], radius, low, high, x, y, heading, skip,
        parts, part_start, shape, pieces, links, edges, cells, frame, pose,
    )  # fmt: skip


@njit(cache=True, error_model="numpy")
def decree(
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
        depth, _, _ = _deepest_of(
            parts, part_start[i], part_start[i + 1], shape[RADIUS, i], shape[LOWEST, i], shape[HIGHEST, i],
            pose[X, i], pose[Y, i], pose[HEADING, i], i,
            parts, part_start, shape, pieces, links, edges, cells, frame, pose,
        )  # fmt: skip
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
        who: int64[k], indices asked for, ascending; a pair of two of them is written down once.
        hits: int64[room, 6], out, as for `resolve`; closing is 0, who is 1.
        hit_numbers: float64[room, 6], out.

    Returns:
        How many hits there are, possibly more than there is room for.
    """
    n = pose.shape[1]
    used = 0
    spots = np.empty((n, 5))
    for i in range(n):
        s, c = sincos(pose[HEADING, i])
        spots[i, _X], spots[i, _Y], spots[i, _H], spots[i, _C], spots[i, _S] = (
            pose[X, i],
            pose[Y, i],
            pose[HEADING, i],
            c,
            s,
        )
    asked = np.zeros(n, dtype=np.int64)
    still = np.zeros((2, n))
    nothing = np.zeros(n + 1, dtype=np.int64)
    scene = _Scene(
        parts,
        part_start,
        shape,
        marks,
        pieces,
        links,
        edges,
        still[0],
        spots,
        spots,
        nothing,
        nothing,
        nothing,
        nothing,
    )
    for i in who:
        asked[i] = 1
    for i in who:
        x, y, c, s = spots[i, _X], spots[i, _Y], spots[i, _C], spots[i, _S]
        items, found = _pieces_near(
            pieces, cells, frame, x, y, shape[RADIUS, i], shape[LOWEST, i], shape[HIGHEST, i],
            np.empty(8, dtype=np.int64), 0,
        )  # fmt: skip
        _sort(items, 0, found)
        depth = TOLERANCE
        piece = NOBODY
        for k in range(found):
            new = _one_piece_depth(
                parts, part_start[i], part_start[i + 1], pieces, links, edges, items[k], x, y, c, s, depth
            )
            if new > depth:
                depth, piece = new, items[k]
        if piece >= 0:
            used = _put_down(scene, hits, hit_numbers, used, still, i, A_WALL, piece, spots, 1)
        for j in range(n):
            if j == i or (asked[j] != 0 and j < i) or _apart(scene, i, x, y, j, spots[j, _X], spots[j, _Y]):
                continue
            if _spot_depth(scene, spots, i, spots, j, TOLERANCE) > TOLERANCE:
                used = _put_down(scene, hits, hit_numbers, used, still, i, j, NOBODY, spots, 1)
    return used


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
