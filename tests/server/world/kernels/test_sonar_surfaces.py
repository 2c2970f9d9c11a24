"""The length of a surface is the same, to the bit, as a look at all faces gives."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from intellwheels_server.world.kernels import face_columns
from intellwheels_server.world.kernels.arrays import Box, Shape, bodies_from
from intellwheels_server.world.kernels.grid_search import Place
from intellwheels_server.world.kernels.sonar_scene import MANY_FACES, gather_scene, scene_room, turn_of
from intellwheels_server.world.kernels.sonar_surfaces import is_long_in_scene, length_in_scene
from intellwheels_server.world.kernels.sonar_widths import is_long, surface_length
from intellwheels_server.world.kernels.spatial_query import place_bodies
from intellwheels_server.world.wall_pieces import Line, Solid, walls_from

LENGTH: Any = length_in_scene
TURN: Any = turn_of


def test_length_among_many_faces_is_that_of_a_look_at_all() -> None:
    """A ring of 120 pieces, short rows of blocks in many directions, and a long row along x."""
    ring = [(3.0 * math.cos(math.tau * k / 120), 3.0 * math.sin(math.tau * k / 120)) for k in range(121)]
    rows = []
    for turn, count in [(0.0, 40), *((0.3 * k, 4) for k in range(1, 20))]:
        c, s = math.cos(turn), math.sin(turn)
        for k in range(count):
            corners = [(0.1 * k, 1.5), (0.1 * k + 0.1, 1.5), (0.1 * k + 0.1, 1.6), (0.1 * k, 1.6)]
            rows.append(Solid([(c * x - s * y, s * x + c * y) for x, y in corners], 0.0, 1.0 + 0.2 * (k % 3)))
    walls = walls_from([Line(ring, 0.1, 0.0, 2.0), *rows])
    bodies = bodies_from([Shape("a", [Box(0.0, 0.0, 1.0, 0.6, 0.0, 1.3)])])
    placed = place_bodies(np.zeros((3, 1)), bodies.parts, bodies.part_start)
    scene = scene_room(placed, walls)
    counts = gather_scene(Place(0.0, 0.0, 6.0, 0, 0), 0.5, placed, scene)
    assert counts.faces > MANY_FACES
    longer = 0
    for face in range(counts.faces):
        for enough, z in ((0.35, 0.5), (2.0, 1.1), (99.0, 0.5)):
            plain = surface_length(face, enough, z, scene.faces, counts.faces)
            assert LENGTH(face, enough, z, scene, counts) == plain
            assert is_long_in_scene(face, enough, z, scene, counts) == is_long(
                face, enough, z, scene.faces, counts.faces
            )
            longer += plain > scene.faces[face, face_columns.LENGTH]
    assert longer > 100


def test_turn_grows_with_the_direction_by_at_most_one_for_each_radian() -> None:
    angles = np.linspace(0.0, math.tau, 1000, endpoint=False)
    turns = np.array([TURN(math.cos(angle), math.sin(angle)) for angle in angles])
    steps = np.diff(turns)
    assert steps.min() > 0.0
    assert steps.max() <= angles[1] * (1.0 + 1e-9)
    assert turns[0] == 0.0
    assert turns[-1] < 4.0
