"""How wide a thing is across the sound, however it was cut: a solid of several wall pieces, a body of several parts.

Pieces that touch are one solid, whichever walls they belong to. Parts of a body that touch are one thing. Faces in one
plane that follow one another are one surface.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import face_columns
from intellwheels_server.world.kernels.arrays import (
    CELL,
    EDGE_X,
    EDGE_Y,
    END_EDGE,
    FIRST_EDGE,
    NORMAL_X,
    NORMAL_Y,
    ORIGIN_X,
    ORIGIN_Y,
    PIECE_BOTTOM,
    PIECE_TOP,
    PIECE_X0,
    PIECE_X1,
    PIECE_Y0,
    PIECE_Y1,
    Floats,
    Ints,
)
from intellwheels_server.world.kernels.grid import cell_of
from intellwheels_server.world.kernels.spatial_query import CENTRE_X, CENTRE_Y, COS, HIGH, LONG, LOW, SIN, WIDE

# Things that are no farther apart than this touch, m.
TOUCH = 1e-6

# Normals that differ by less than this are one direction, rad.
_PARALLEL = 1e-6


@njit(cache=True, error_model="numpy")
def _gap(one: int, other: int, links: Ints, edges: Floats) -> float:
    """Return by how much an edge of a piece separates another piece from it, m; the largest of all edges."""
    widest = -np.inf
    for edge in range(links[one, FIRST_EDGE], links[one, END_EDGE]):
        nearest = np.inf
        for at in range(links[other, FIRST_EDGE], links[other, END_EDGE]):
            beyond = edges[edge, NORMAL_X] * (edges[at, EDGE_X] - edges[edge, EDGE_X]) + edges[edge, NORMAL_Y] * (
                edges[at, EDGE_Y] - edges[edge, EDGE_Y]
            )
            nearest = min(nearest, beyond)
        widest = max(widest, nearest)
    return widest


@njit(cache=True, error_model="numpy")
def _touch(one: int, other: int, pieces: Floats, links: Ints, edges: Floats) -> bool:
    """Return whether two wall pieces touch."""
    return bool(
        pieces[one, PIECE_X0] <= pieces[other, PIECE_X1] + TOUCH
        and pieces[other, PIECE_X0] <= pieces[one, PIECE_X1] + TOUCH
        and pieces[one, PIECE_Y0] <= pieces[other, PIECE_Y1] + TOUCH
        and pieces[other, PIECE_Y0] <= pieces[one, PIECE_Y1] + TOUCH
        and pieces[one, PIECE_BOTTOM] < pieces[other, PIECE_TOP]
        and pieces[other, PIECE_BOTTOM] < pieces[one, PIECE_TOP]
        and _gap(one, other, links, edges) <= TOUCH
        and _gap(other, one, links, edges) <= TOUCH
    )


@njit(cache=True, error_model="numpy")
def gather_solid(
    piece: int, dx: float, dy: float, enough: float, pieces: Floats, links: Ints, edges: Floats, cells: Ints,
    frame: Floats, members: Ints, marks: Ints,
) -> tuple[int, float, float]:  # fmt: skip
    """Return the number of pieces of a solid, and how far it reaches to either side of a direction.

    Args:
        piece: One of its pieces.
        dx: The direction, a unit vector; what is to its left counts from 0 at the origin of the map, m.
        dy: The same.
        enough: The search ends when it has found a solid that is wider than this, m.
        pieces: Of the walls, as the next four.
        links: Of the walls.
        edges: Of the walls.
        cells: Of the walls.
        frame: Of the walls.
        members: int64[>= pieces], out: the pieces.
        marks: int64[pieces + 1], scratch: the last search that found each piece, and the number of searches.
    """
    number = marks[pieces.shape[0]] + 1
    marks[pieces.shape[0]] = number
    members[0], marks[piece] = piece, number
    count, looked = 1, 0
    low, high = np.inf, -np.inf
    while looked < count:
        at = members[looked]
        looked += 1
        for edge in range(links[at, FIRST_EDGE], links[at, END_EDGE]):
            aside = dx * edges[edge, EDGE_Y] - dy * edges[edge, EDGE_X]
            low, high = min(low, aside), max(high, aside)
        if high - low > enough:
            break
        x0, x1 = pieces[at, PIECE_X0] - TOUCH, pieces[at, PIECE_X1] + TOUCH
        y0, y1 = pieces[at, PIECE_Y0] - TOUCH, pieces[at, PIECE_Y1] + TOUCH
        first_column = cell_of(x0, frame[ORIGIN_X], frame[CELL], cells[0])
        last_column = cell_of(x1, frame[ORIGIN_X], frame[CELL], cells[0])
        for row in range(
            cell_of(y0, frame[ORIGIN_Y], frame[CELL], cells[1]), cell_of(y1, frame[ORIGIN_Y], frame[CELL], cells[1]) + 1
        ):
            for place in range(cells[2 + row * cells[0] + first_column], cells[2 + row * cells[0] + last_column + 1]):
                other = cells[place]
                if marks[other] != number and _touch(at, other, pieces, links, edges):
                    marks[other] = number
                    members[count] = other
                    count += 1
    return count, low, high


@njit(cache=True, error_model="numpy")
def body_span(
    box: int, z: float, dx: float, dy: float, boxes: Floats, owners: Ints, box_count: int, members: Ints
) -> tuple[float, float]:
    """Return how far a body reaches to either side of a direction, with all parts that are joined to one of them.

    Args:
        box: One of its parts.
        z: Height, m.
        dx: The direction, a unit vector; what is to its left counts from 0 at the origin of the map, m.
        dy: The same.
        boxes: Of the scene, as the next two; the parts of a body follow one another.
        owners: Of the scene.
        box_count: Of the scene.
        members: int64[>= parts], scratch.
    """
    begin, end = box, box + 1
    while begin > 0 and owners[begin - 1] == owners[box]:
        begin -= 1
    while end < box_count and owners[end] == owners[box]:
        end += 1
    c, s = boxes[box, COS], boxes[box, SIN]
    low, high = np.inf, -np.inf
    members[0] = box
    count, looked = 1, 0
    while looked < count:
        at = members[looked]
        looked += 1
        middle = dx * boxes[at, CENTRE_Y] - dy * boxes[at, CENTRE_X]
        half = boxes[at, LONG] * abs(c * dy - s * dx) + boxes[at, WIDE] * abs(c * dx + s * dy)
        low, high = min(low, middle - half), max(high, middle + half)
        for other in range(begin, end):
            known = False
            for member in range(count):
                known |= members[member] == other
            if known or not boxes[other, LOW] <= z < boxes[other, HIGH]:
                continue
            to_x, to_y = boxes[other, CENTRE_X] - boxes[at, CENTRE_X], boxes[other, CENTRE_Y] - boxes[at, CENTRE_Y]
            if (
                abs(c * to_x + s * to_y) <= boxes[at, LONG] + boxes[other, LONG] + TOUCH
                and abs(c * to_y - s * to_x) <= boxes[at, WIDE] + boxes[other, WIDE] + TOUCH
            ):
                members[count] = other
                count += 1
    return low, high


@njit(cache=True, error_model="numpy")
def surface_length(face: int, enough: float, z: float, faces: Floats, count: int) -> float:
    """Return the length of a face with those that continue it in its plane, m.

    Args:
        face: Its row.
        enough: The search ends when it has found this length, m.
        z: Height, m: faces at other heights do not count.
        faces: Of the scene.
        count: How many faces the scene has.
    """
    nx, ny = faces[face, face_columns.NX], faces[face, face_columns.NY]
    first, last = 0.0, faces[face, face_columns.LENGTH]
    grows = True
    while last - first < enough and grows:
        grows = False
        for other in range(count):
            to_x = faces[other, face_columns.X] - faces[face, face_columns.X]
            to_y = faces[other, face_columns.Y] - faces[face, face_columns.Y]
            if abs(nx * to_x + ny * to_y) > TOUCH or not (
                faces[other, face_columns.LOW] <= z < faces[other, face_columns.HIGH]
            ):
                continue
            mx, my = faces[other, face_columns.NX], faces[other, face_columns.NY]
            if nx * mx + ny * my <= 0.0 or abs(nx * my - ny * mx) > _PARALLEL:
                continue
            begin = nx * to_y - ny * to_x
            end = begin + faces[other, face_columns.LENGTH]
            if begin <= last + TOUCH and end >= first - TOUCH and (begin < first - TOUCH or end > last + TOUCH):
                first, last, grows = min(first, begin), max(last, end), True
    return float(last - first)


@njit(cache=True, error_model="numpy")
def is_long(face: int, least: float, z: float, faces: Floats, count: int) -> bool:
    """Return whether a face with those that continue it has at least a length: see `surface_length`."""
    return bool(surface_length(face, least, z, faces, count) >= least)
