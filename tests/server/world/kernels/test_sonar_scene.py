"""What is around a mount of sonars: the faces of walls without inner cuts, and posts."""

from __future__ import annotations

import numpy as np
import pytest

from intellwheels_server.world.kernels import face_columns
from intellwheels_server.world.kernels.arrays import Box, Shape, bodies_from
from intellwheels_server.world.kernels.grid_search import Place
from intellwheels_server.world.kernels.sonar_scene import (
    Counts,
    Scene,
    gather_scene,
    scene_room,
)
from intellwheels_server.world.kernels.spatial_query import place_bodies
from intellwheels_server.world.wall_pieces import Line, Solid, Walls, walls_from

# Like the letter U: cut into several convex pieces.
_LETTER = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (3.0, 3.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]


def _gathered(walls: Walls, reach: float = 20.0, owner: int = 0, spread: float = 0.5) -> tuple[Scene, Counts]:
    bodies = bodies_from([Shape(name, [Box(0.0, 0.0, 1.0, 0.6, 0.0, 1.3)]) for name in "ab"])
    placed = place_bodies(np.array([[0.0, 6.0], [0.0, 1.0], [0.0, 0.0]]), bodies.parts, bodies.part_start)
    scene = scene_room(placed, walls)
    return scene, gather_scene(Place(0.0, 0.0, reach, owner, 0), spread, placed, scene)


def test_faces_of_a_concave_wall_are_its_outline() -> None:
    scene, counts = _gathered(walls_from([Solid(_LETTER, 0.0, 1.0)]))
    assert counts.near > 1
    assert counts.posts == 0
    assert sorted(scene.faces[: counts.faces, face_columns.LENGTH]) == pytest.approx(
        [1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 4.0]
    )


def test_wall_is_a_post_if_all_its_pieces_together_are_small() -> None:
    small = [(0.02 * x, 0.02 * y) for x, y in _LETTER]
    chain = [(1.0 + 0.05 * k, 0.05 * (k % 2)) for k in range(40)]
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
        normals = [tuple(face) for face in scene.faces[:4, [face_columns.NX, face_columns.NY]].tolist()]
        assert set(normals[: counts.front]) == front
        assert len(set(normals)) == 4
    # Nor does a face belong to the scene that is out of reach, though its piece is within.
    assert _gathered(walls, reach=3.0)[1].faces == 3


def test_blocks_that_touch_are_one_solid_and_no_posts() -> None:
    blocks = [[(2.0, 0.1 * k), (2.1, 0.1 * k), (2.1, 0.1 * k + 0.1), (2.0, 0.1 * k + 0.1)] for k in range(5)]
    for count, posts in ((1, 1), (2, 0), (5, 0)):
        walls = walls_from([Solid(block, 0.0, 1.0) for block in blocks[:count]])
        assert _gathered(walls)[1].posts == posts
    # One above the other does not make it longer, nor does one 1 mm away.
    above = [Solid(blocks[0], 0.0, 1.0), Solid(blocks[1], 1.0, 2.0)]
    apart = [Solid(blocks[0], 0.0, 1.0), Solid([(x, y + 0.001) for x, y in blocks[1]], 0.0, 1.0)]
    for solids in (above, apart):
        assert _gathered(walls_from(solids))[1].posts == 2
    # What it touches counts even out of reach.
    assert _gathered(walls_from([Solid(block, 0.0, 1.0) for block in blocks[:2]]), reach=2.02)[1].posts == 0
