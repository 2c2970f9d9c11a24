"""What is around a mount of sonars: the faces of walls without inner cuts, posts, and what hides what."""

from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_server.world.kernels.arrays import Box, Shape, bodies_from
from intellwheels_server.world.kernels.sonar_scene import (
    FACE_LENGTH,
    FACE_NX,
    FACE_NY,
    Counts,
    Scene,
    blocked,
    gather_scene,
    scene_room,
    wall_is_wider,
    width_of_box,
)
from intellwheels_server.world.kernels.spatial_query import Place, place_bodies
from intellwheels_server.world.wall_pieces import Line, Solid, Walls, walls_from

# Like the letter U: cut into several convex pieces.
_LETTER = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (3.0, 3.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]


def _gathered(walls: Walls, reach: float = 20.0, owner: int = 0, spread: float = 0.5) -> tuple[Scene, Counts]:
    bodies = bodies_from([Shape(name, [Box(0.0, 0.0, 1.0, 0.6, 0.0, 1.3)]) for name in "ab"])
    placed = place_bodies(np.array([[0.0, 6.0], [0.0, 1.0], [0.0, 0.0]]), bodies.parts, bodies.part_start)
    scene = scene_room(placed, walls)
    return scene, gather_scene(Place(0.0, 0.0, reach, owner, 0), spread, placed, walls, scene)


def test_faces_of_a_concave_wall_are_its_outline() -> None:
    scene, counts = _gathered(walls_from([Solid(_LETTER, 0.0, 1.0)]))
    assert counts.near > 1
    assert counts.posts == 0
    assert sorted(scene.faces[: counts.faces, FACE_LENGTH]) == pytest.approx([1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 4.0])


def test_wall_is_a_post_if_all_its_pieces_together_are_small() -> None:
    small = [(0.02 * x, 0.02 * y) for x, y in _LETTER]
    chain = [(0.05 * k, 0.05 * (k % 2)) for k in range(40)]
    walls = walls_from([Solid(small, 0.0, 1.0), Line(chain, 0.01, 0.0, 1.0)])
    scene, counts = _gathered(walls)
    assert counts.near == len(walls.links)
    found = walls.links[scene.posts[: counts.posts], 2]
    assert set(found.tolist()) == {0}
    assert len(found) == int((walls.links[:, 2] == 0).sum())


def test_owner_and_what_is_out_of_reach_are_left_out() -> None:
    walls = walls_from([Solid([(9.0, 0.0), (10.0, 0.0), (10.0, 1.0)], 0.0, 1.0)])
    assert _gathered(walls)[1][:2] == (1, 1)
    scene, counts = _gathered(walls, reach=8.0)
    assert counts == (1, 0, 0, 0, 0)
    assert scene.owners[0] == 1
    assert _gathered(walls, reach=4.0)[1] == (0, 0, 0, 0, 0)


def test_faces_that_no_sonar_is_in_front_of_come_last() -> None:
    walls = walls_from([Solid([(2.0, -1.0), (4.0, -1.0), (4.0, 1.0), (2.0, 1.0)], 0.0, 1.0)])
    for spread, front in ((0.5, {(-1.0, 0.0)}), (1.5, {(-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)})):
        scene, counts = _gathered(walls, spread=spread)
        assert counts.faces == 4
        normals = [tuple(face) for face in scene.faces[:4, [FACE_NX, FACE_NY]].tolist()]
        assert set(normals[: counts.front]) == front
        assert len(set(normals)) == 4
    # Nor does a face belong to the scene that is out of reach, though its piece is within.
    assert _gathered(walls, reach=3.0)[1].faces == 3


def test_widths_across_a_direction() -> None:
    boxes = np.array([[0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 2.0, 0.5]])
    assert width_of_box(boxes, 0, 1.0, 0.0) == 1.0
    assert width_of_box(boxes, 0, 0.0, 1.0) == 4.0
    assert width_of_box(boxes, 0, math.sqrt(0.5), math.sqrt(0.5)) == pytest.approx(5.0 * math.sqrt(0.5))
    walls = walls_from([Solid(_LETTER, 0.0, 1.0)])
    for piece in range(len(walls.links)):
        for (dx, dy), width in (((1.0, 0.0), 3.0), ((0.0, 1.0), 4.0)):
            assert wall_is_wider(piece, dx, dy, width - 1e-9, walls.links, walls.edges)
            assert not wall_is_wider(piece, dx, dy, width + 1e-9, walls.links, walls.edges)


def test_thing_hides_if_it_can_be_heard_at_its_distance() -> None:
    walls = walls_from([Solid([(2.0, -0.05), (2.1, -0.05), (2.1, 0.05), (2.0, 0.05)], 0.0, 1.0)])
    scene, counts = _gathered(walls)

    def hidden(to_x: float, to_y: float, thin: float, gone: float = 0.0, through: int = -1, z: float = 0.5) -> bool:
        return bool(
            blocked(
                0.0, 0.0, z, to_x, to_y, gone, thin, through, scene.boxes, scene.owners, counts.boxes, scene.near,
                counts.near, walls.pieces, walls.links, walls.edges,
            )
        )  # fmt: skip

    assert hidden(4.0, 0.0, 0.0)
    assert not hidden(1.9, 0.0, 0.0)
    assert not hidden(2.0, 0.0, 0.0)  # a surface does not hide its own points
    assert not hidden(4.0, 0.0, 0.0, z=1.0)
    # 0.1 m wide at 2 m.
    assert hidden(4.0, 0.0, 0.1 / 8.0 - 1e-4)
    assert not hidden(4.0, 0.0, 0.1 / 8.0 + 1e-4)
    assert not hidden(4.0, 0.0, 0.1 / 8.0 - 1e-4, gone=1.0)
    # The other body.
    assert hidden(7.0, 1.0, 0.0)
    assert not hidden(7.0, 1.0, 0.0, through=1)
