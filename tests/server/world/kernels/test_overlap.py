import numpy as np

from intellwheels_server.world.kernels.arrays import Box, part_rows, radius_of
from intellwheels_server.world.kernels.overlap import deepest_body, deepest_wall
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
