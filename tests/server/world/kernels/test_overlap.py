import random

import numpy as np

from intellwheels_server.world.kernels.arrays import Box, part_rows, radius_of
from intellwheels_server.world.kernels.overlap import deepest_body, deepest_wall, overlaps_wall
from intellwheels_server.world.wall_pieces import Solid, walls_from

BOX = [Box(0.0, 0.0, 1.0, 0.6, 0.0, 1.0)]
WALLS = walls_from(
    [
        Solid([(0.4, -5.0), (1.4, -5.0), (1.4, 5.0), (0.4, 5.0)], 0.0, 2.5),
        Solid([(-1.4, -5.0), (-0.3, -5.0), (-0.3, 5.0), (-1.4, 5.0)], 1.0, 2.5),
    ]
)


def wall(boxes: list[Box], x: float = 0.0) -> tuple[float, int]:
    depth, which = deepest_wall(part_rows(boxes), radius_of(boxes), x, 0.0, 0.0, WALLS.pieces, WALLS.links, WALLS.edges)
    return round(float(depth), 12), int(which)


def test_deepest_wall_is_the_one_that_shares_its_height() -> None:
    assert wall(BOX) == (0.1, 0)
    assert wall([Box(0.0, 0.0, 1.0, 0.6, 0.0, 1.001)]) == (0.2, 1)


def test_nothing_near_is_no_depth() -> None:
    assert wall(BOX, x=0.7) == (0.8, 0)
    assert wall(BOX, x=50.0) == (0.0, -1)


def test_deepest_body_leaves_the_asker_out() -> None:
    poses = np.array([[0.0, 0.9, -0.7], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    others = np.concatenate([part_rows(BOX)] * 3)
    starts = np.array([0, 1, 2, 3])
    radii = np.full(3, radius_of(BOX))
    asked = (part_rows(BOX), radius_of(BOX), 0.0, 0.0, 0.0, poses, radii, others, starts)
    depth, which = deepest_body(*asked, 0)
    assert (round(float(depth), 12), int(which)) == (0.3, 2)
    assert deepest_body(*asked, -1)[1] == 0


def test_overlap_of_a_wall_is_found_wherever_there_is_a_depth() -> None:
    chance = random.Random(3)
    found = 0
    boxes = [Box(0.0, 0.0, 1.0, 0.6, 0.0, 1.0), Box(2.0, 0.5, 0.3, 3.0, 0.5, 2.0), Box(-3.0, 0.0, 0.1, 0.1, 3.0, 4.0)]
    parts, radius = part_rows(boxes), radius_of(boxes)
    slanted = Solid([(3.0, -4.0), (9.0, 2.0), (8.0, 3.0), (2.0, -3.0)], 0.0, 2.5)
    walls = walls_from([slanted, Solid([(-2.0, -2.0), (-1.0, -2.0), (-1.5, 4.0)], 1.5, 2.5)])
    for _ in range(2000):
        pose = (chance.uniform(-9.0, 12.0), chance.uniform(-9.0, 9.0), chance.uniform(-3.0, 3.0))
        depth, _ = deepest_wall(parts, radius, *pose, walls.pieces, walls.links, walls.edges)
        found_one = overlaps_wall(parts, *pose, walls.pieces, walls.links, walls.edges, walls.cells, walls.frame, 1e-9)
        assert found_one == (depth > 1e-9)
        found += depth > 1e-9
    assert 200 < found < 1800
