"""Overlaps of a body at a pose, for a body that joins, is spawned or is moved there."""

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
    PIECE_X0,
    PIECE_X1,
    PIECE_Y0,
    PIECE_Y1,
    TOP,
    WALL,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.geometry import body_depth, piece_depth


@njit(cache=True, error_model="numpy")
def deepest_wall(
    parts: Floats, radius: float, x: float, y: float, heading: float, pieces: Floats, links: Ints, edges: Floats
) -> tuple[float, int]:
    """Return the largest depth to which a body overlaps a wall piece, m, at least 0, and the wall's index or -1.

    Args:
        parts: Part block of the body.
        radius: Its farthest corner, m.
        x: Its pose.
        y: Its pose.
        heading: Its pose.
        pieces: Piece block of the walls.
        links: Links block of the walls.
        edges: Edge block of the walls.
    """
    s, c = sincos(heading)
    deepest, which = 0.0, -1
    for piece in range(pieces.shape[0]):
        if (
            pieces[piece, PIECE_X0] - radius > x
            or pieces[piece, PIECE_X1] + radius < x
            or pieces[piece, PIECE_Y0] - radius > y
            or pieces[piece, PIECE_Y1] + radius < y
        ):
            continue
        for i in range(parts.shape[0]):
            if max(parts[i, BOTTOM], pieces[piece, PIECE_BOTTOM]) >= min(parts[i, TOP], pieces[piece, PIECE_TOP]):
                continue
            depth = piece_depth(
                links,
                edges,
                piece,
                x + (c * parts[i, PART_X] - s * parts[i, PART_Y]),
                y + (s * parts[i, PART_X] + c * parts[i, PART_Y]),
                c,
                s,
                parts[i, HALF_LENGTH],
                parts[i, HALF_WIDTH],
                deepest,
            )
            if depth > deepest:
                deepest, which = depth, links[piece, WALL]
    return deepest, which


@njit(cache=True, error_model="numpy")
def deepest_body(
    parts: Floats,
    radius: float,
    x: float,
    y: float,
    heading: float,
    poses: Floats,
    radii: Floats,
    others: Floats,
    starts: Ints,
    skip: int,
) -> tuple[float, int]:
    """Return the largest depth to which a body overlaps another, m, at least 0, and that body's column or -1.

    Args:
        parts: Part block of the body.
        radius: Its farthest corner, m.
        x: Its pose.
        y: Its pose.
        heading: Its pose.
        poses: Pose block of the others.
        radii: float64[n], their farthest corners, m.
        others: Part block of the others.
        starts: int64[n + 1], the first part of each of them and the end.
        skip: Column of the others to leave out, or -1.
    """
    s, c = sincos(heading)
    deepest, which = 0.0, -1
    for j in range(poses.shape[1]):
        dx, dy = poses[rows.X, j] - x, poses[rows.Y, j] - y
        reach = radius + radii[j]
        if j == skip or dx * dx + dy * dy > reach * reach:
            continue
        sj, cj = sincos(poses[rows.HEADING, j])
        depth = body_depth(
            parts,
            0,
            parts.shape[0],
            x,
            y,
            c,
            s,
            others,
            starts[j],
            starts[j + 1],
            poses[rows.X, j],
            poses[rows.Y, j],
            cj,
            sj,
            deepest,
        )
        if depth > deepest:
            deepest, which = depth, j
    return deepest, which
