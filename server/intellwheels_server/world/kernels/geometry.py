"""Rigid boxes in the plane: the pose after an arc, and the depth of overlap of two things.

Depth is the least translation that separates two convex figures if they overlap. Otherwise it is minus the widest gap
along any of their axes. Each axis is used in its owner's frame and with absolute values, so that the depth of i in j
equals that of j in i to the last bit.

A function that takes `floor`, a lower bound, returns the largest of the depths and this bound. It stops early where
the bound cannot be exceeded. A caller that only asks whether a depth exceeds a limit passes the limit.

Source:
    Separating axes of convex figures (Gottschalk, Lin, Manocha, OBBTree, 1996), in the plane.
"""

import numpy as np
from numba import njit

from intellwheels_server.world.kernels.arrays import (
    BOTTOM,
    EDGE_X,
    EDGE_Y,
    END_EDGE,
    FIRST_EDGE,
    HALF_LENGTH,
    HALF_WIDTH,
    NORMAL_X,
    NORMAL_Y,
    OFFSET,
    PART_X,
    PART_Y,
    TOP,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.elementary import sincos, wrap

# Depths along two axes that differ by less count as equal, m: the rounding of coordinates of some kilometres.
_PARALLEL = 1e-12


@njit(cache=True, error_model="numpy")
def arc(x: float, y: float, heading: float, travel: float, turn: float) -> tuple[float, float, float, float, float]:
    """Return the pose after an arc, and the cosine and sine of its heading.

    Args:
        x: Start, m.
        y: Start, m.
        heading: At the start, in (-pi, pi].
        travel: Length of the arc, m, negative backwards.
        turn: Angle turned along it, rad, anticlockwise.
    """
    half = 0.5 * turn
    # The chord of an arc is sin(half) / half of its length; a series where that quotient loses digits.
    chord = travel * (1.0 - turn * turn / 24.0) if abs(turn) < 1e-6 else travel * (sincos(half)[0] / half)
    s, c = sincos(heading + half)
    x += chord * c
    y += chord * s
    heading = wrap(heading + turn)
    s, c = sincos(heading)
    return x, y, heading, c, s


@njit(cache=True, error_model="numpy")
def box_depth(
    ax: float,
    ay: float,
    ac: float,
    a_s: float,
    al: float,
    aw: float,
    bx: float,
    by: float,
    bc: float,
    bs: float,
    bl: float,
    bw: float,
    floor: float,
) -> float:
    """Return the depth to which two boxes overlap, m, or the lower bound.

    Args:
        ax: Centre of box a.
        ay: Centre of box a.
        ac: Cosine of its heading.
        a_s: Sine of its heading.
        al: Half its length.
        aw: Half its width.
        bx: The same of box b.
        by: The same of box b.
        bc: The same of box b.
        bs: The same of box b.
        bl: The same of box b.
        bw: The same of box b.
        floor: What a depth must exceed to count.
    """
    dx = bx - ax
    dy = by - ay
    along = abs(ac * bc + a_s * bs)
    across = abs(ac * bs - a_s * bc)
    least = al + (bl * along + bw * across) - abs(dx * ac + dy * a_s)
    if least <= floor:
        return floor
    other = aw + (bl * across + bw * along) - abs(dy * ac - dx * a_s)
    if other <= floor:
        return floor
    least = min(least, other)
    other = bl + (al * along + aw * across) - abs(dx * bc + dy * bs)
    if other <= floor:
        return floor
    least = min(least, other)
    other = bw + (al * across + aw * along) - abs(dy * bc - dx * bs)
    if other <= floor:
        return floor
    return min(least, other)


@njit(cache=True, error_model="numpy")
def part_depth(
    parts: Floats,
    i: int,
    xi: float,
    yi: float,
    ci: float,
    si: float,
    others: Floats,
    j: int,
    xj: float,
    yj: float,
    cj: float,
    sj: float,
    floor: float,
) -> float:
    """Return the depth of part i of one body in part j of another, m; the lower bound if their z ranges are apart."""
    if max(parts[i, BOTTOM], others[j, BOTTOM]) >= min(parts[i, TOP], others[j, TOP]):
        return floor
    return box_depth(
        xi + (ci * parts[i, PART_X] - si * parts[i, PART_Y]),
        yi + (si * parts[i, PART_X] + ci * parts[i, PART_Y]),
        ci,
        si,
        parts[i, HALF_LENGTH],
        parts[i, HALF_WIDTH],
        xj + (cj * others[j, PART_X] - sj * others[j, PART_Y]),
        yj + (sj * others[j, PART_X] + cj * others[j, PART_Y]),
        cj,
        sj,
        others[j, HALF_LENGTH],
        others[j, HALF_WIDTH],
        floor,
    )


@njit(cache=True, error_model="numpy")
def body_depth(
    parts: Floats,
    i0: int,
    i1: int,
    xi: float,
    yi: float,
    ci: float,
    si: float,
    others: Floats,
    j0: int,
    j1: int,
    xj: float,
    yj: float,
    cj: float,
    sj: float,
    floor: float,
) -> float:
    """Return the depth of a body in another, m: the largest over pairs of parts; or the lower bound.

    Args:
        parts: Part block of the one body.
        i0: Its first part.
        i1: One past its last.
        xi: Its pose, m.
        yi: Its pose, m.
        ci: Cosine of its heading.
        si: Sine of its heading.
        others: Part block of the other body.
        j0: Its first part.
        j1: One past its last.
        xj: Its pose, m.
        yj: Its pose, m.
        cj: Cosine of its heading.
        sj: Sine of its heading.
        floor: What a depth must exceed to count.
    """
    deepest = floor
    for i in range(i0, i1):
        for j in range(j0, j1):
            deepest = part_depth(parts, i, xi, yi, ci, si, others, j, xj, yj, cj, sj, deepest)
    return deepest


@njit(cache=True, error_model="numpy")
def _clamped(px: float, py: float, x: float, y: float, c: float, s: float, hl: float, hw: float) -> tuple[float, float]:
    """Return the point of a box that is nearest to a point."""
    u = min(max((px - x) * c + (py - y) * s, -hl), hl)
    v = min(max((py - y) * c - (px - x) * s, -hw), hw)
    return x + (c * u - s * v), y + (s * u + c * v)


@njit(cache=True, error_model="numpy")
def _deepest_point(
    nx: float, ny: float, x: float, y: float, c: float, s: float, hl: float, hw: float
) -> tuple[float, float]:
    """Return the point of a box that lies farthest along n, or the middle of its side if a whole side does."""
    u = nx * c + ny * s
    v = ny * c - nx * s
    u = 0.0 if abs(u) < 1e-9 else (hl if u > 0.0 else -hl)
    v = 0.0 if abs(v) < 1e-9 else (hw if v > 0.0 else -hw)
    return x + (c * u - s * v), y + (s * u + c * v)


@njit(cache=True, error_model="numpy")
def body_contact(
    parts: Floats,
    a0: int,
    a1: int,
    xa: float,
    ya: float,
    ca: float,
    sa: float,
    b0: int,
    b1: int,
    xb: float,
    yb: float,
    cb: float,
    sb: float,
) -> tuple[float, float, float, int, int, float, float]:
    """Return where two bodies meet: depth, normal (x, y), part of a, part of b, point (x, y).

    The normal is a unit vector along which a leaves b by moving as far as the depth. Of equal parts and axes the first
    counts. If a is always the body with the lower key, the answer does not depend on the order of the two.
    """
    deepest = -np.inf
    part_a, part_b = a0, b0
    for i in range(a0, a1):
        for j in range(b0, b1):
            depth = part_depth(parts, i, xa, ya, ca, sa, parts, j, xb, yb, cb, sb, deepest)
            if depth > deepest:
                deepest = depth
                part_a, part_b = i, j
    ax = xa + (ca * parts[part_a, PART_X] - sa * parts[part_a, PART_Y])
    ay = ya + (sa * parts[part_a, PART_X] + ca * parts[part_a, PART_Y])
    bx = xb + (cb * parts[part_b, PART_X] - sb * parts[part_b, PART_Y])
    by = yb + (sb * parts[part_b, PART_X] + cb * parts[part_b, PART_Y])
    al, aw = parts[part_a, HALF_LENGTH], parts[part_a, HALF_WIDTH]
    bl, bw = parts[part_b, HALF_LENGTH], parts[part_b, HALF_WIDTH]
    dx, dy = bx - ax, by - ay
    along = abs(ca * cb + sa * sb)
    across = abs(ca * sb - sa * cb)
    reach = dx * ca + dy * sa
    least = al + (bl * along + bw * across) - abs(reach)
    ux, uy = ca, sa
    owner_is_a = True
    side = dy * ca - dx * sa
    depth = aw + (bl * across + bw * along) - abs(side)
    if depth < least:
        least, reach, ux, uy = depth, side, -sa, ca
    side = dx * cb + dy * sb
    depth = bl + (al * along + aw * across) - abs(side)
    if depth < least:
        least, reach, ux, uy, owner_is_a = depth, side, cb, sb, False
    side = dy * cb - dx * sb
    depth = bw + (al * across + aw * along) - abs(side)
    if depth < least:
        least, reach, ux, uy, owner_is_a = depth, side, -sb, cb, False
    if reach >= 0.0:
        ux, uy = -ux, -uy
    if owner_is_a:
        px, py = _deepest_point(ux, uy, bx, by, cb, sb, bl, bw)
        px, py = _clamped(px, py, ax, ay, ca, sa, al, aw)
    else:
        px, py = _deepest_point(-ux, -uy, ax, ay, ca, sa, al, aw)
        px, py = _clamped(px, py, bx, by, cb, sb, bl, bw)
    return deepest, ux, uy, part_a, part_b, px, py


@njit(cache=True, error_model="numpy")
def piece_depth(
    links: Ints, edges: Floats, piece: int, x: float, y: float, c: float, s: float, hl: float, hw: float, floor: float
) -> float:
    """Return the depth of a box in a wall piece, m, or the lower bound. The caller compares their z ranges.

    Args:
        links: Links block of the walls.
        edges: Edge block of the walls.
        piece: Which piece.
        x: Centre of the box.
        y: Centre of the box.
        c: Cosine of its heading.
        s: Sine of its heading.
        hl: Half its length.
        hw: Half its width.
        floor: What a depth must exceed to count.
    """
    least = np.inf
    low_u = low_v = np.inf
    high_u = high_v = -np.inf
    for k in range(links[piece, FIRST_EDGE], links[piece, END_EDGE]):
        nx, ny = edges[k, NORMAL_X], edges[k, NORMAL_Y]
        depth = edges[k, OFFSET] + (hl * abs(nx * c + ny * s) + hw * abs(ny * c - nx * s)) - (nx * x + ny * y)
        if depth <= floor:
            return floor
        least = min(least, depth)
        dx, dy = edges[k, EDGE_X] - x, edges[k, EDGE_Y] - y
        u = dx * c + dy * s
        v = dy * c - dx * s
        low_u, high_u = min(low_u, u), max(high_u, u)
        low_v, high_v = min(low_v, v), max(high_v, v)
    least = min(least, high_u + hl, hl - low_u)
    least = min(least, high_v + hw, hw - low_v)
    return max(least, floor)


@njit(cache=True, error_model="numpy")
def piece_contact(
    links: Ints, edges: Floats, piece: int, x: float, y: float, c: float, s: float, hl: float, hw: float
) -> tuple[float, float, float, float, float]:
    """Return where a box meets a wall piece: depth, normal (x, y) along which the box leaves it, point (x, y)."""
    least = np.inf
    normal_x = normal_y = 0.0
    low_u = low_v = np.inf
    high_u = high_v = -np.inf
    first, end = links[piece, FIRST_EDGE], links[piece, END_EDGE]
    for k in range(first, end):
        nx, ny = edges[k, NORMAL_X], edges[k, NORMAL_Y]
        depth = edges[k, OFFSET] + (hl * abs(nx * c + ny * s) + hw * abs(ny * c - nx * s)) - (nx * x + ny * y)
        if depth < least:
            least, normal_x, normal_y = depth, nx, ny
        dx, dy = edges[k, EDGE_X] - x, edges[k, EDGE_Y] - y
        u = dx * c + dy * s
        v = dy * c - dx * s
        low_u, high_u = min(low_u, u), max(high_u, u)
        low_v, high_v = min(low_v, v), max(high_v, v)
    # If a side of the box is parallel to the wall, both axes agree but for rounding. Then the axis of the wall counts.
    rival = least - _PARALLEL
    of_wall = True
    if high_u + hl < rival:
        rival, normal_x, normal_y, of_wall = high_u + hl, c, s, False
    if hl - low_u < rival:
        rival, normal_x, normal_y, of_wall = hl - low_u, -c, -s, False
    if high_v + hw < rival:
        rival, normal_x, normal_y, of_wall = high_v + hw, -s, c, False
    if hw - low_v < rival:
        rival, normal_x, normal_y, of_wall = hw - low_v, s, -c, False
    least = min(least, high_u + hl, hl - low_u)
    least = min(least, high_v + hw, hw - low_v)
    if of_wall:
        px, py = _deepest_point(-normal_x, -normal_y, x, y, c, s, hl, hw)
        return least, normal_x, normal_y, px, py
    # The corner of the wall that is deepest in the box.
    best = -np.inf
    px, py = x, y
    for k in range(first, end):
        along = edges[k, EDGE_X] * normal_x + edges[k, EDGE_Y] * normal_y
        if along > best:
            best, px, py = along, edges[k, EDGE_X], edges[k, EDGE_Y]
    px, py = _clamped(px, py, x, y, c, s, hl, hw)
    return least, normal_x, normal_y, px, py
