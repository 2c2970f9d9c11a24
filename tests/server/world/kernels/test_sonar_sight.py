"""What hides what from a sonar: by its width at its distance, however it was cut."""

from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_server.world.kernels.arrays import Box, Shape, bodies_from
from intellwheels_server.world.kernels.grid_search import Place
from intellwheels_server.world.kernels.sonar_scene import Counts, Scene, gather_scene, scene_room
from intellwheels_server.world.kernels.sonar_sight import blocked, box_is_wide, outline, piece_is_wide
from intellwheels_server.world.kernels.spatial_query import place_bodies
from intellwheels_server.world.wall_pieces import Solid, Walls, walls_from

# Like the letter U: cut into several convex pieces.
_LETTER = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (3.0, 3.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]


def _gathered(walls: Walls, boxes: list[Box], x: float = 6.0, y: float = 1.0) -> tuple[Scene, Counts]:
    bodies = bodies_from([Shape("a", [Box(0.0, 0.0, 1.0, 0.6, 0.0, 1.3)]), Shape("b", boxes)])
    placed = place_bodies(np.array([[0.0, x], [0.0, y], [0.0, 0.0]]), bodies.parts, bodies.part_start)
    scene = scene_room(placed, walls)
    return scene, gather_scene(Place(0.0, 0.0, 20.0, 0, 0), 0.5, placed, scene)


def test_widths_across_a_direction() -> None:
    walls = walls_from([Solid(_LETTER, 0.0, 1.0)])
    scene, counts = _gathered(walls, [Box(0.0, 0.0, 4.0, 1.0, 0.0, 1.0)])
    for (dx, dy), width in (((1.0, 0.0), 1.0), ((0.0, 1.0), 4.0), ((math.sqrt(0.5),) * 2, 5.0 * math.sqrt(0.5))):
        assert box_is_wide(0, 0.5, dx, dy, width - 1e-9, scene, counts)
        assert not box_is_wide(0, 0.5, dx, dy, width + 1e-9, scene, counts)
    for piece in range(len(walls.links)):
        for (dx, dy), width in (((1.0, 0.0), 3.0), ((0.0, 1.0), 4.0)):
            assert piece_is_wide(piece, dx, dy, width - 1e-9, scene)
            assert not piece_is_wide(piece, dx, dy, width + 1e-9, scene)


@pytest.mark.parametrize("cuts", [1, 3, 10])
def test_width_does_not_depend_on_the_cut(cuts: int) -> None:
    step = 0.5 / cuts
    slats = [Box(0.0, step * (k + 0.5), 0.05, step, 0.0, 1.0) for k in range(cuts)]
    blocks = [[(2.0, step * k), (2.1, step * k), (2.1, step * (k + 1)), (2.0, step * (k + 1))] for k in range(cuts)]
    scene, counts = _gathered(walls_from([Solid(block, 0.0, 1.0) for block in blocks]), slats)
    for at in range(cuts):
        assert box_is_wide(at, 0.5, 1.0, 0.0, 0.499, scene, counts)
        assert not box_is_wide(at, 0.5, 1.0, 0.0, 0.501, scene, counts)
        assert piece_is_wide(at, 1.0, 0.0, 0.499, scene)
        assert not piece_is_wide(at, 1.0, 0.0, 0.501, scene)


def test_legs_of_a_table_are_not_as_wide_as_the_table() -> None:
    legs = [Box(x, y, 0.05, 0.05, 0.0, 0.7) for x in (-0.5, 0.5) for y in (-0.3, 0.3)]
    scene, counts = _gathered(walls_from([]), [*legs, Box(0.0, 0.0, 1.2, 0.8, 0.69, 0.72)])
    assert not box_is_wide(0, 0.4, 1.0, 0.0, 0.051, scene, counts)
    assert box_is_wide(0, 0.69, 1.0, 0.0, 0.79, scene, counts)  # joined by the top


def test_thing_hides_if_it_can_be_heard_at_its_distance() -> None:
    walls = walls_from([Solid([(2.0, -0.05), (2.1, -0.05), (2.1, 0.05), (2.0, 0.05)], 0.0, 1.0)])
    scene, counts = _gathered(walls, [Box(0.0, 0.0, 1.0, 0.6, 0.0, 1.3)])

    def hidden(to_x: float, to_y: float, thin: float, gone: float = 0.0, through: int = -1, z: float = 0.5) -> bool:
        return bool(blocked(0.0, 0.0, z, to_x, to_y, gone, thin, through, scene, counts))

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


def test_outline_of_a_box_is_between_its_outermost_corners() -> None:
    sides = np.array([[2.0, -1.0], [3.0, -1.0], [3.0, 1.0], [2.0, 1.0]])
    assert outline(sides, 4) == (2.0, -1.0, 2.0, 1.0)
