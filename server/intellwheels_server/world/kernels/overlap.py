"""Overlaps of a body at a pose, for a body that joins, is spawned or is moved there."""

from numba import njit

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import (
    BOTTOM,
    CELL,
    HALF_LENGTH,
    HALF_WIDTH,
    ORIGIN_X,
    ORIGIN_Y,
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
from intellwheels_server.world.kernels.grid import cell_of


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
def overlaps_wall(
    parts: Floats, x: float, y: float, heading: float, pieces: Floats, links: Ints, edges: Floats, cells: Ints,
    frame: Floats, least: float,
) -> bool:  # fmt: skip
    """Return whether a body overlaps a wall piece. It ends at the first one, and looks only where a part is.

    Args:
        parts: Part block of the body.
        x: Its pose.
        y: Its pose.
        heading: Its pose.
        pieces: Piece block of the walls.
        links: Links block of the walls.
        edges: Edge block of the walls.
        cells: The grid of the pieces.
        frame: Its origin and the size of a cell.
        least: Depth that counts as an overlap if it is exceeded, m.
    """
    s, c = sincos(heading)
    columns, lines = cells[0], cells[1]
    for i in range(parts.shape[0]):
        middle_x = x + (c * parts[i, PART_X] - s * parts[i, PART_Y])
        middle_y = y + (s * parts[i, PART_X] + c * parts[i, PART_Y])
        half_x = abs(c) * parts[i, HALF_LENGTH] + abs(s) * parts[i, HALF_WIDTH]
        half_y = abs(s) * parts[i, HALF_LENGTH] + abs(c) * parts[i, HALF_WIDTH]
        first_line = cell_of(middle_y - half_y, frame[ORIGIN_Y], frame[CELL], lines)
        last_line = cell_of(middle_y + half_y, frame[ORIGIN_Y], frame[CELL], lines)
        first_column = cell_of(middle_x - half_x, frame[ORIGIN_X], frame[CELL], columns)
        last_column = cell_of(middle_x + half_x, frame[ORIGIN_X], frame[CELL], columns)
        for line in range(first_line, last_line + 1):
            for item in range(cells[2 + line * columns + first_column], cells[2 + line * columns + last_column + 1]):
                piece = cells[item]
                if (
                    pieces[piece, PIECE_X0] > middle_x + half_x
                    or pieces[piece, PIECE_X1] < middle_x - half_x
                    or pieces[piece, PIECE_Y0] > middle_y + half_y
                    or pieces[piece, PIECE_Y1] < middle_y - half_y
                ):
                    continue
                if max(parts[i, BOTTOM], pieces[piece, PIECE_BOTTOM]) >= min(parts[i, TOP], pieces[piece, PIECE_TOP]):
                    continue
                half_length, half_width = parts[i, HALF_LENGTH], parts[i, HALF_WIDTH]
                if piece_depth(links, edges, piece, middle_x, middle_y, c, s, half_length, half_width, least) > least:
                    return True
    return False


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
