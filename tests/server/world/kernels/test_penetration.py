"""What may stand: touching may, deeper than at the start of the sub-step may not, a licence widens it."""

import math

import numpy as np
import pytest

from intellwheels_server.world.kernels.arrays import Box, part_rows
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.penetration import (
    A_WALL,
    NOBODY,
    OF_KEY,
    OF_NEAR,
    OF_PARTS,
    OF_WALLS,
    SPOT_ALLOWED,
    SPOT_RADIUS,
    body_excess,
    contact_of,
    may_stand,
    set_spot,
    slide,
    wall_excess,
)
from intellwheels_server.world.wall_pieces import Solid, walls_from

PARTS = part_rows([Box(0.0, 0.0, 2.0, 1.0, 0.0, 1.0)] * 2)
# The wall's face is the line x = 5.
WALLS = walls_from([Solid([(5.0, -9.0), (6.0, -9.0), (6.0, 9.0), (5.0, 9.0)], 0.0, 1.0)])
BLOCKS = (PARTS, WALLS.pieces, WALLS.links, WALLS.edges)
AROUND = np.array([1, 0, 0, 0], dtype=np.int64)


def index() -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """Two bodies, each the other's partner, each near the wall."""
    rows = np.zeros((3, 5), dtype=np.int64)
    rows[:, OF_PARTS] = rows[:, OF_NEAR] = [0, 1, 2]
    rows[:, OF_WALLS] = [2, 3, 4]
    rows[:2, OF_KEY] = [7, 3]
    return rows


INDEX = index()


def spots(
    *poses: tuple[float, float, float], allowed: tuple[float, float] = (0.0, 0.0)
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    rows = np.zeros((2, 7))
    for i, (x, y, heading) in enumerate(poses):
        s, c = sincos(heading)
        set_spot(rows, i, x, y, heading, c, s)
        rows[i, SPOT_RADIUS], rows[i, SPOT_ALLOWED] = math.sqrt(1.25), allowed[i]
    return rows


def test_touching_may_stand_and_overlapping_may_not() -> None:
    old = spots((0.0, 0.0, 0.0), (3.0, 0.0, 0.0))
    assert may_stand(PARTS, INDEX, old, spots((1.0, 0.0, 0.0), (9.0, 0.0, 0.0)), 0, old, 1)
    assert may_stand(PARTS, INDEX, old, spots((1.0 + 9e-10, 0.0, 0.0), (9.0, 0.0, 0.0)), 0, old, 1)
    assert not may_stand(PARTS, INDEX, old, spots((1.0 + 2e-9, 0.0, 0.0), (9.0, 0.0, 0.0)), 0, old, 1)


def test_what_was_deeper_may_stay_so_and_not_get_deeper() -> None:
    old = spots((1.25, 0.0, 0.0), (3.0, 0.0, 0.0))
    assert body_excess(PARTS, INDEX, old, old, 0, 1.25, 0.0, 1.0, 0.0, 1) == (0.0, 0.0)
    assert body_excess(PARTS, INDEX, old, old, 0, 1.5, 0.0, 1.0, 0.0, 1) == (0.25, 0.25)
    assert body_excess(PARTS, INDEX, old, old, 0, 1.125, 0.0, 1.0, 0.0, 1)[0] < 0.0


@pytest.mark.parametrize("allowed", [(0.5, 0.0), (0.0, 0.5)])
def test_allowed_penetration_of_either_counts_where_they_overlapped(allowed: tuple[float, float]) -> None:
    old = spots((1.25, 0.0, 0.0), (3.0, 0.0, 0.0), allowed=allowed)
    assert body_excess(PARTS, INDEX, old, old, 0, 1.5, 0.0, 1.0, 0.0, 1)[0] == 0.0
    apart = spots((1.0, 0.0, 0.0), (3.0, 0.0, 0.0), allowed=allowed)
    assert body_excess(PARTS, INDEX, apart, apart, 0, 1.5, 0.0, 1.0, 0.0, 1)[0] == pytest.approx(0.5 - 1e-9)


def test_wall_is_one_partner_and_named_by_its_piece() -> None:
    old = spots((4.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert wall_excess(*BLOCKS, INDEX, AROUND, old, 0, 4.0, 0.0, 1.0, 0.0) == (0.0, 0.0, NOBODY)
    assert wall_excess(*BLOCKS, INDEX, AROUND, old, 0, 4.5, 0.0, 1.0, 0.0) == (0.5 - 1e-9, 0.5, A_WALL)


def test_slide_moves_out_along_the_normal_and_no_farther_than_it_may() -> None:
    old = spots((3.9, 0.0, 0.0), (0.0, 0.0, 0.0))
    found, x, y = slide(*BLOCKS, INDEX, AROUND, old, old, 0, 4.0625, 0.25, 1.0, 0.0, 0.0626)
    assert (found, y) == (True, 0.25)
    assert x == pytest.approx(4.0, abs=2e-12)
    assert slide(*BLOCKS, INDEX, AROUND, old, old, 0, 4.0625, 0.25, 1.0, 0.0, 0.0624)[0] is False


def test_slide_that_may_not_move_only_asks() -> None:
    old = spots((3.9, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert slide(*BLOCKS, INDEX, AROUND, old, old, 0, 4.0, 0.0, 1.0, 0.0, 0.0) == (True, 4.0, 0.0)
    assert slide(*BLOCKS, INDEX, AROUND, old, old, 0, 4.1, 0.0, 1.0, 0.0, 0.0) == (False, 4.1, 0.0)


def test_contact_is_one_whoever_asks() -> None:
    at = spots((0.0, 0.0, 0.2), (1.8, 0.3, -0.1))
    args = (*BLOCKS, INDEX, at)
    depth, nx, ny, part, other, px, py = contact_of(*args, 0, 0.0, 0.0, math.cos(0.2), math.sin(0.2), 1)
    back = contact_of(*args, 1, 1.8, 0.3, math.cos(-0.1), math.sin(-0.1), 0)
    assert back == (depth, -nx, -ny, other, part, px, py)
    assert depth > 0.0
