"""What is around a mount of sonars: parts of bodies, wall pieces, and the faces of walls that reflect like mirrors.

A face is an edge of a wall. Edges along which a wall was cut into convex pieces are inside the wall, so they are no
faces. A solid is a post if no two of its corners are farther apart than `POST`. Posts and bodies are rough: they have
no faces in this sense.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from intellwheels_server.world.kernels import face_columns
from intellwheels_server.world.kernels.arrays import (
    EDGE_X,
    EDGE_Y,
    END_EDGE,
    FIRST_EDGE,
    NORMAL_X,
    NORMAL_Y,
    OUTER,
    PIECE_BOTTOM,
    PIECE_TOP,
    Floats,
    Ints,
    Walls,
)
from intellwheels_server.world.kernels.grid_search import Place, bodies_near, pieces_near
from intellwheels_server.world.kernels.sonar_widths import gather_solid
from intellwheels_server.world.kernels.spatial_query import PlacedBodies

# A solid is a post if no two of its corners are farther apart than this, m; chosen.
POST = 0.15

# A ray begins so far after its start and ends so far before its end, so that a surface does not hide its own points, m.
SKIN = 1e-6


class Scene(NamedTuple):
    """All walls, and buffers for what is around one mount after the other.

    Attributes:
        boxes: float64[parts, 10], columns of a block of boxes: the parts of bodies, those of a body together.
        owners: int64[parts], the body of each box.
        near: int64[pieces], wall pieces.
        posts: int64[pieces], those of them that are posts.
        faces: float64[edges, 7], columns of `face_columns`; those that no sonar is in front of come last.
        close: int64[2 edges], scratch for faces.
        sides: float64[2, most sides, 6], scratch for two side blocks.
        views: float64[VIEWS, 6], scratch of `sonar_rough`.
        found: int64[bodies], scratch.
        found_for: int64[pieces], as `grid_search.pieces_near` takes it.
        posts_known: int64[pieces], 1 for a post, 0 for none, -1 if not looked at yet.
        members: int64[pieces or parts], scratch of `sonar_widths`.
        marks: int64[pieces + 1], scratch of the same.
        pieces: Of the walls, as the next four.
        links: Of the walls.
        edges: Of the walls.
        cells: Of the walls.
        frame: Of the walls.
    """

    boxes: Floats
    owners: Ints
    near: Ints
    posts: Ints
    faces: Floats
    close: Ints
    sides: Floats
    views: Floats
    found: Ints
    found_for: Ints
    posts_known: Ints
    members: Ints
    marks: Ints
    pieces: Floats
    links: Ints
    edges: Floats
    cells: Ints
    frame: Floats


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


# Columns of a side block: see `sonar_faces`.
SIDE_COLUMNS = 6

# Room for directions in which the nearest point of a rough thing is still to be looked for; see `sonar_rough`.
VIEWS = 64


@njit(cache=True, error_model="numpy")
def scene_room(placed: PlacedBodies, walls: Walls) -> Scene:
    """Return the walls and buffers for all that can be around a mount."""
    parts, pieces, edges = placed.boxes.shape[0], walls.pieces.shape[0], walls.edges.shape[0]
    most = 4
    for piece in range(pieces):
        most = max(most, walls.links[piece, END_EDGE] - walls.links[piece, FIRST_EDGE])
    return Scene(
        np.empty((parts, 10)),
        np.empty(parts, np.int64),
        np.empty(pieces, np.int64),
        np.empty(pieces, np.int64),
        np.empty((edges, face_columns.COUNT)),
        np.empty(2 * edges, np.int64),
        np.empty((2, most, SIDE_COLUMNS)),
        np.empty((VIEWS, 6)),
        np.empty(placed.extents.shape[0], np.int64),
        np.full(pieces, -1, np.int64),
        np.full(pieces, -1, np.int64),
        np.empty(max(pieces, parts), np.int64),
        np.zeros(pieces + 1, np.int64),
        walls.pieces,
        walls.links,
        walls.edges,
        walls.cells,
        walls.frame,
    )


@njit(cache=True, error_model="numpy")
def _is_post(
    piece: int, pieces: Floats, links: Ints, edges: Floats, cells: Ints, frame: Floats, members: Ints, marks: Ints
) -> bool:
    """Return whether the solid of a piece is a post: no two of its corners are farther apart than `POST`."""
    for across in range(2):
        count, low, high = gather_solid(
            piece, float(across), 1.0 - across, POST, pieces, links, edges, cells, frame, members, marks
        )
        if high - low > POST:
            return False
    for one in range(count):
        for other in range(one + 1):
            for a in range(links[members[one], FIRST_EDGE], links[members[one], END_EDGE]):
                for b in range(links[members[other], FIRST_EDGE], links[members[other], END_EDGE]):
                    dx, dy = edges[a, EDGE_X] - edges[b, EDGE_X], edges[a, EDGE_Y] - edges[b, EDGE_Y]
                    if dx * dx + dy * dy > POST * POST:
                        return False
    return True


@njit(cache=True, error_model="numpy")
def gather_scene(place: Place, spread: float, placed: PlacedBodies, scene: Scene) -> Counts:
    """Gather what is within reach of a mount.

    Args:
        place: The mount; the body that owns it is left out.
        spread: The largest distance of its sonars from it, m.
        placed: All bodies.
        scene: Out.
    """
    x, y, reach, _, _ = place
    part_start, boxes, extents, cell_start, cell_bodies, grid = placed
    pieces, links, edges, cells, frame = scene.pieces, scene.links, scene.edges, scene.cells, scene.frame
    near, posts, faces, posts_known = scene.near, scene.posts, scene.faces, scene.posts_known
    box_count = post_count = front_count = face_count = 0
    for at in range(bodies_near(place, extents, cell_start, cell_bodies, grid, scene.found)):
        body = scene.found[at]
        for part in range(part_start[body], part_start[body + 1]):
            for column in range(10):
                scene.boxes[box_count, column] = boxes[part, column]
            scene.owners[box_count] = body
            box_count += 1
    near_count = pieces_near(place, pieces, cells, frame, near, scene.found_for)
    for at in range(near_count):
        piece = near[at]
        if posts_known[piece] < 0:
            posts_known[piece] = _is_post(piece, pieces, links, edges, cells, frame, scene.members, scene.marks)
        if posts_known[piece] > 0:
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
            if height * height + beyond * beyond > reach * reach:
                continue
            at_face = face_count
            if height < spread:
                for column in range(face_columns.COUNT):
                    faces[face_count, column] = faces[front_count, column]
                at_face = front_count
                front_count += 1
            faces[at_face, face_columns.X], faces[at_face, face_columns.Y] = px, py
            faces[at_face, face_columns.NX], faces[at_face, face_columns.NY] = nx, ny
            faces[at_face, face_columns.LENGTH] = length
            faces[at_face, face_columns.LOW] = pieces[piece, PIECE_BOTTOM]
            faces[at_face, face_columns.HIGH] = pieces[piece, PIECE_TOP]
            face_count += 1
    return Counts(box_count, near_count, post_count, front_count, face_count)
