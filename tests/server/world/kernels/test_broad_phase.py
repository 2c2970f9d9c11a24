"""Who could meet whom: the grids find what looking at every pair finds."""

import numpy as np

from intellwheels_server.world.kernels.arrays import PIECE_BOTTOM, PIECE_TOP, Floats, Ints, Walls
from intellwheels_server.world.kernels.broad_phase import pairs_near, piece_apart, pieces_near
from intellwheels_server.world.wall_pieces import Line, walls_from
from tests.every_case import every_case

RNG = np.random.default_rng(20)


def listed(found: Ints) -> list[tuple[int, int]]:
    return sorted((int(found[k]), int(found[k + 1])) for k in range(1, found[0], 2))


@every_case("count", [1, 2, 11, 12, 150])
@every_case("side", [0.0, 12.0, 2e5])
@every_case("giant", [False, True])
def test_pairs_are_those_whose_circles_meet(count: int, side: float, giant: bool) -> None:
    pose = np.vstack([RNG.uniform(-side, side, (2, count)), np.zeros(count)])
    wide = RNG.uniform(0.05, 1.5, count)
    if giant:
        wide[0] = 40.0
    motion = np.where(RNG.random(count) < 0.7, 0.1, 0.0)
    shape = np.zeros((4, count))
    shape[1] = RNG.choice([0.0, 0.5], count)
    shape[2] = shape[1] + 0.5
    expected = [
        (i, j)
        for i in range(count)
        for j in range(i + 1, count)
        if (motion[i] > 0.0 or motion[j] > 0.0)
        and (pose[0, i] - pose[0, j]) ** 2 + (pose[1, i] - pose[1, j]) ** 2 < (wide[i] + wide[j]) ** 2
        and shape[1, i] == shape[1, j]
    ]
    assert listed(pairs_near(shape, pose, motion, wide)) == expected


def floor() -> Walls:
    lines = []
    for x, y in RNG.uniform(0.0, 30.0, (80, 2)).tolist():
        dx, dy = RNG.normal(0.0, 3.0, 2).tolist()
        bottom = float(RNG.choice([0.0, 1.0]))
        lines.append(Line([(x, y), (x + dx, y + dy)], 0.1, bottom, bottom + 1.0))
    return walls_from(lines)


def circles() -> Floats:
    return np.column_stack([RNG.uniform(-5.0, 35.0, (200, 2)), RNG.uniform(0.0, 4.0, 200)])


def test_wall_pieces_are_those_whose_boxes_meet_the_circle() -> None:
    walls = floor()
    found = np.empty(4, dtype=np.int64)
    found[:2] = 2
    for x, y, radius in circles().tolist():
        begin = int(found[0])
        found = pieces_near(walls.pieces, walls.cells, walls.frame, x, y, radius, 0.5, 1.0, found)
        expected = [
            piece
            for piece in range(len(walls.pieces))
            if walls.pieces[piece, PIECE_BOTTOM] < 1.0
            and walls.pieces[piece, PIECE_TOP] > 0.5
            and not piece_apart(walls.pieces, piece, x, y, radius)
        ]
        # Appended behind those of the circle before, sorted, each once.
        assert found[begin : found[0]].tolist() == expected
