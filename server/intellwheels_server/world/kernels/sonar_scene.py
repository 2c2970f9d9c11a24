"""What is around a mount of sonars: parts of bodies, wall pieces, and the faces of walls that reflect like mirrors.

A face is an edge of a wall. Edges along which a wall was cut into convex pieces are inside the wall, so they are no
faces. A wall is a post if no two of its corners are farther apart than `POST`. Posts and bodies are rough: they have no
faces in this sense.

A thing hides what is behind it only if it is wide enough to be heard itself. A wall counts as wide as all its pieces
together.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

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
    OUTER,
    PIECE_BOTTOM,
    PIECE_TOP,
    PIECE_X0,
    PIECE_X1,
    PIECE_Y0,
    PIECE_Y1,
    WALL,
    Floats,
    Ints,
    Walls,
)
from intellwheels_server.world.kernels.grid import cell_of
from intellwheels_server.world.kernels.line_of_sight import ray_to_polygon
from intellwheels_server.world.kernels.spatial_query import (
    CENTRE_X,
    CENTRE_Y,
    COS,
    HIGH,
    LONG,
    LOW,
    SIN,
    WIDE,
    Place,
    PlacedBodies,
)
from intellwheels_server.world.kernels.wedge_distance import ray_to_box

# A wall is a post if no two of its corners are farther apart than this, m; chosen.
POST = 0.15

# Columns of a face block, float64[faces, 7]: corner (the face runs anticlockwise around its wall, along (-ny, nx)),
# unit normal outwards, length, z range.
FACE_X, FACE_Y, FACE_NX, FACE_NY, FACE_LENGTH, FACE_LOW, FACE_HIGH = 0, 1, 2, 3, 4, 5, 6
FACE_COLUMNS = 7

# A ray begins so far after its start and ends so far before its end, so that a surface does not hide its own points, m.
SKIN = 1e-6


class Scene(NamedTuple):
    """Buffers for what is around one mount after the other.

    Attributes:
        boxes: float64[parts, 10], columns of a block of boxes: the parts of bodies.
        owners: int64[parts], the body of each box.
        near: int64[pieces], wall pieces.
        posts: int64[pieces], those of them that are posts.
        faces: float64[edges, 7], columns `FACE_X` to `FACE_HIGH`; those that no sonar is in front of come last.
        found_for: int64[pieces], the last mount for which a piece was found, -1 for none.
    """

    boxes: Floats
    owners: Ints
    near: Ints
    posts: Ints
    faces: Floats
    found_for: Ints


class Counts(NamedTuple):
    """How many things a scene holds.

    Attributes:
        boxes: Parts of bodies.
        near: Wall pieces.
        posts: Posts among them.
        front: Faces that a sonar of the mount can be in front of.
        faces: All faces.
    """

    boxes: int
    near: int
    posts: int
    front: int
    faces: int


@njit(cache=True, error_model="numpy")
def scene_room(placed: PlacedBodies, walls: Walls) -> Scene:
    """Return buffers for all that can be around a mount."""
    parts, pieces = placed.boxes.shape[0], walls.pieces.shape[0]
    return Scene(
        np.empty((parts, 10)),
        np.empty(parts, np.int64),
        np.empty(pieces, np.int64),
        np.empty(pieces, np.int64),
        np.empty((walls.edges.shape[0], FACE_COLUMNS)),
        np.full(pieces, -1, np.int64),
    )


@njit(cache=True, error_model="numpy")
def _is_post(piece: int, pieces: Floats, links: Ints, edges: Floats) -> bool:
    """Return whether the wall of a piece is a post: no two of its corners are farther apart than `POST`."""
    if max(pieces[piece, PIECE_X1] - pieces[piece, PIECE_X0], pieces[piece, PIECE_Y1] - pieces[piece, PIECE_Y0]) > POST:
        return False
    # The pieces of a wall follow one another.
    begin, end = piece, piece + 1
    while begin > 0 and links[begin - 1, WALL] == links[piece, WALL]:
        begin -= 1
    while end < links.shape[0] and links[end, WALL] == links[piece, WALL]:
        end += 1
    x, y = pieces[piece, PIECE_X0], pieces[piece, PIECE_Y0]
    for at in range(begin, end):  # before corners are compared in pairs: is the wall far too large?
        if max(abs(pieces[at, PIECE_X1] - x), abs(pieces[at, PIECE_Y1] - y)) > POST:
            return False
    first, last = links[begin, FIRST_EDGE], links[end - 1, END_EDGE]
    for one in range(first, last):
        for other in range(first, one):
            dx = edges[one, EDGE_X] - edges[other, EDGE_X]
            dy = edges[one, EDGE_Y] - edges[other, EDGE_Y]
            if dx * dx + dy * dy > POST * POST:
                return False
    return True


@njit(cache=True, error_model="numpy")
def gather_scene(place: Place, spread: float, placed: PlacedBodies, walls: Walls, scene: Scene) -> Counts:
    """Gather what is within reach of a mount.

    Args:
        place: The mount; the body that owns it is left out.
        spread: The largest distance of its sonars from it, m.
        placed: All bodies.
        walls: All walls.
        scene: Out.
    """
    x, y, reach, owner, number = place
    part_start, boxes, extents, cell_start, cell_bodies, grid = placed
    pieces, links, edges, cells, frame = walls
    near_boxes, owners, near, posts, faces, found_for = scene
    reach_square = reach * reach
    box_count = near_count = post_count = front_count = face_count = 0
    low_x, low_y, size, columns, row_count, widest_x, widest_y = grid
    first_column = cell_of(x - reach - widest_x, low_x, size, columns)
    last_column = cell_of(x + reach + widest_x, low_x, size, columns)
    for row in range(
        cell_of(y - reach - widest_y, low_y, size, row_count), cell_of(y + reach + widest_y, low_y, size, row_count) + 1
    ):
        for at in range(cell_start[row * columns + first_column], cell_start[row * columns + last_column + 1]):
            body = cell_bodies[at]
            gap_x = max(abs(extents[body, 0] - x) - extents[body, 2], 0.0)
            gap_y = max(abs(extents[body, 1] - y) - extents[body, 3], 0.0)
            if body != owner and gap_x * gap_x + gap_y * gap_y <= reach_square:
                for part in range(part_start[body], part_start[body + 1]):
                    for column in range(10):
                        near_boxes[box_count, column] = boxes[part, column]
                    owners[box_count] = body
                    box_count += 1
    first_column = cell_of(x - reach, frame[ORIGIN_X], frame[CELL], cells[0])
    last_column = cell_of(x + reach, frame[ORIGIN_X], frame[CELL], cells[0])
    for row in range(
        cell_of(y - reach, frame[ORIGIN_Y], frame[CELL], cells[1]),
        cell_of(y + reach, frame[ORIGIN_Y], frame[CELL], cells[1]) + 1,
    ):
        for at in range(cells[2 + row * cells[0] + first_column], cells[2 + row * cells[0] + last_column + 1]):
            piece = cells[at]
            if found_for[piece] == number:
                continue
            found_for[piece] = number
            gap_x = max(pieces[piece, PIECE_X0] - x, x - pieces[piece, PIECE_X1], 0.0)
            gap_y = max(pieces[piece, PIECE_Y0] - y, y - pieces[piece, PIECE_Y1], 0.0)
            if gap_x * gap_x + gap_y * gap_y > reach_square:
                continue
            near[near_count] = piece
            near_count += 1
            if _is_post(piece, pieces, links, edges):
                posts[post_count] = piece
                post_count += 1
                continue
            first, end = links[piece, FIRST_EDGE], links[piece, END_EDGE]
            for edge in range(first, end):
                if edges[edge, OUTER] == 0.0:
                    continue
                after = edge + 1 if edge + 1 < end else first
                nx, ny = edges[edge, NORMAL_X], edges[edge, NORMAL_Y]
                px, py = edges[edge, EDGE_X], edges[edge, EDGE_Y]
                length = nx * (edges[after, EDGE_Y] - py) - ny * (edges[after, EDGE_X] - px)
                height, along = nx * (px - x) + ny * (py - y), ny * (px - x) - nx * (py - y)
                beyond = max(-along, along - length, 0.0)
                if height * height + beyond * beyond > reach_square:
                    continue
                at_face = face_count
                if height < spread:
                    for column in range(FACE_COLUMNS):
                        faces[face_count, column] = faces[front_count, column]
                    at_face = front_count
                    front_count += 1
                faces[at_face, FACE_X], faces[at_face, FACE_Y] = px, py
                faces[at_face, FACE_NX], faces[at_face, FACE_NY] = nx, ny
                faces[at_face, FACE_LENGTH] = length
                faces[at_face, FACE_LOW], faces[at_face, FACE_HIGH] = (
                    pieces[piece, PIECE_BOTTOM],
                    pieces[piece, PIECE_TOP],
                )
                face_count += 1
    return Counts(box_count, near_count, post_count, front_count, face_count)


@njit(cache=True, error_model="numpy")
def width_of_box(boxes: Floats, at: int, dx: float, dy: float) -> float:
    """Return the width of a box across a direction, a unit vector, m."""
    c, s = boxes[at, COS], boxes[at, SIN]
    return float(2.0 * (boxes[at, LONG] * abs(c * dy - s * dx) + boxes[at, WIDE] * abs(c * dx + s * dy)))


@njit(cache=True, error_model="numpy")
def wall_is_wider(piece: int, dx: float, dy: float, least: float, links: Ints, edges: Floats) -> bool:
    """Return whether the wall of a piece has at least a width across a direction, a unit vector."""
    low, high = np.inf, -np.inf
    for step in (1, -1):
        at = piece
        while 0 <= at < links.shape[0] and links[at, WALL] == links[piece, WALL]:
            for edge in range(links[at, FIRST_EDGE], links[at, END_EDGE]):
                aside = dx * edges[edge, EDGE_Y] - dy * edges[edge, EDGE_X]
                low, high = min(low, aside), max(high, aside)
            if high - low >= least:
                return True
            at += step
    return False


@njit(cache=True, error_model="numpy")
def blocked(
    x: float,
    y: float,
    z: float,
    to_x: float,
    to_y: float,
    gone: float,
    thin: float,
    through: int,
    boxes: Floats,
    owners: Ints,
    box_count: int,
    near: Ints,
    near_count: int,
    pieces: Floats,
    links: Ints,
    edges: Floats,
) -> bool:
    """Return whether something that can be heard begins on the way from a place to a point.

    Args:
        x: The place, m.
        y: The same.
        z: Height, m.
        to_x: The point, from the place, m.
        to_y: The same.
        gone: How far the sound has gone before the place, m.
        thin: What is narrower than this times the cube of its distance is not heard, 1/m2.
        through: A body that hides nothing, -1 for none.
        boxes: Of the scene, as the next two.
        owners: Of the scene.
        box_count: Of the scene.
        near: Of the scene, as the next one.
        near_count: Of the scene.
        pieces: Of the walls, as the next two.
        links: Of the walls.
        edges: Of the walls.
    """
    length = math.sqrt(to_x * to_x + to_y * to_y)
    far = length - 2.0 * SKIN
    if far <= 0.0:
        return False
    dx, dy = to_x / length, to_y / length
    x += SKIN * dx
    y += SKIN * dy
    for at in range(box_count):
        if owners[at] == through or not boxes[at, LOW] <= z < boxes[at, HIGH]:
            continue
        c, s = boxes[at, COS], boxes[at, SIN]
        from_x, from_y = x - boxes[at, CENTRE_X], y - boxes[at, CENTRE_Y]
        way = ray_to_box(
            c * from_x + s * from_y,
            c * from_y - s * from_x,
            c * dx + s * dy,
            c * dy - s * dx,
            boxes[at, LONG],
            boxes[at, WIDE],
        )
        if way < far:
            distance = gone + max(way, 0.0)
            if width_of_box(boxes, at, dx, dy) >= thin * distance * distance * distance:
                return True
    x0, x1 = min(x, x + far * dx), max(x, x + far * dx)
    y0, y1 = min(y, y + far * dy), max(y, y + far * dy)
    for at in range(near_count):
        piece = near[at]
        if not pieces[piece, PIECE_BOTTOM] <= z < pieces[piece, PIECE_TOP]:
            continue
        if pieces[piece, PIECE_X0] > x1 or pieces[piece, PIECE_X1] < x0:
            continue
        if pieces[piece, PIECE_Y0] > y1 or pieces[piece, PIECE_Y1] < y0:
            continue
        way, _ = ray_to_polygon(edges, links[piece, FIRST_EDGE], links[piece, END_EDGE], x, y, dx, dy)
        if way < far:
            distance = gone + way
            if wall_is_wider(piece, dx, dy, thin * distance * distance * distance, links, edges):
                return True
    return False
