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
        ranks: int64[pieces], the place of each of them in `near`; of other pieces something.
        posts: int64[pieces], those of them that are posts.
        faces: float64[edges, 7], columns of `face_columns`; those that no sonar is in front of come last.
        close: int64[2 edges], scratch for faces.
        turn_of: float64[edges], the direction of each face as `turn_of` gives it, where there are many.
        turns: float64[edges], the same, ascending.
        by_turn: int64[edges], the faces in this order.
        alike: int64[MOST_ALIKE], scratch of `sonar_surfaces`.
        alike_faces: float64[MOST_ALIKE, 7], scratch of the same.
        face_marks: int64[edges], scratch of `sonar_face_grid`, as the next two.
        corners: float64[2, 3].
        met: int64[edges].
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
    ranks: Ints
    posts: Ints
    faces: Floats
    close: Ints
    turn_of: Floats
    turns: Floats
    by_turn: Ints
    alike: Ints
    alike_faces: Floats
    face_marks: Ints
    corners: Floats
    met: Ints
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

# Faces around a mount from which on they are sorted by direction, and the most that are copied for one of them.
MANY_FACES = 256
MOST_ALIKE = 32

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
        np.zeros(pieces, np.int64),
        np.empty(pieces, np.int64),
        np.empty((edges, face_columns.COUNT)),
        np.empty(2 * edges, np.int64),
        np.empty(edges),
        np.empty(edges),
        np.empty(edges, np.int64),
        np.empty(MOST_ALIKE, np.int64),
        np.empty((MOST_ALIKE, face_columns.COUNT)),
        np.empty(edges, np.int64),
        np.empty((2, 3)),
        np.empty(edges, np.int64),
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
def turn_of(x: float, y: float) -> float:
    """Return a number in [0, 4] that grows with the direction of a vector, by at most 1 for each radian."""
    share = y / (abs(x) + abs(y))
    if x < 0.0:
        return 2.0 - share
    return share if share >= 0.0 else 4.0 + share


@njit(cache=True, error_model="numpy")
def _find_posts(
    piece: int, pieces: Floats, links: Ints, edges: Floats, cells: Ints, frame: Floats, members: Ints, marks: Ints,
    posts_known: Ints,
) -> None:  # fmt: skip
    """Store for some pieces of a solid, one of which is given, whether they are of a post.

    The search ends where the solid is too wide for a post. What it has found by then is of the same solid.
    """
    count, is_post = _post_pieces(piece, pieces, links, edges, cells, frame, members, marks)
    for at in range(count):
        posts_known[members[at]] = is_post


@njit(cache=True, error_model="numpy")
def _post_pieces(
    piece: int, pieces: Floats, links: Ints, edges: Floats, cells: Ints, frame: Floats, members: Ints, marks: Ints
) -> tuple[int, bool]:
    """Return how many pieces of a solid it found, and whether no two corners are farther apart than `POST`."""
    for across in range(2):
        count, low, high = gather_solid(
            piece, float(across), 1.0 - across, POST, pieces, links, edges, cells, frame, members, marks
        )
        if high - low > POST:
            return count, False
    for one in range(count):
        for other in range(one + 1):
            for a in range(links[members[one], FIRST_EDGE], links[members[one], END_EDGE]):
                for b in range(links[members[other], FIRST_EDGE], links[members[other], END_EDGE]):
                    dx, dy = edges[a, EDGE_X] - edges[b, EDGE_X], edges[a, EDGE_Y] - edges[b, EDGE_Y]
                    if dx * dx + dy * dy > POST * POST:
                        return count, False
    return count, True


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
        scene.ranks[piece] = at
        if posts_known[piece] < 0:
            _find_posts(piece, pieces, links, edges, cells, frame, scene.members, scene.marks, posts_known)
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
    if face_count >= MANY_FACES:
        for face in range(face_count):
            scene.turn_of[face] = turn_of(faces[face, face_columns.NX], faces[face, face_columns.NY])
        scene.by_turn[:face_count] = np.argsort(scene.turn_of[:face_count])
        for at in range(face_count):
            scene.turns[at] = scene.turn_of[scene.by_turn[at]]
    return Counts(box_count, near_count, post_count, front_count, face_count)
