"""Who of a pair collides: the one whose own proposal brings it nearer."""

import numpy as np
import pytest

from intellwheels_server.world.kernels.arrays import COLLIDED, TOUCHED, Box, Floats, part_rows
from intellwheels_server.world.kernels.contact_hits import flag_collision
from intellwheels_server.world.kernels.penetration import OF_PARTS, set_spot

PARTS = part_rows([Box(0.0, 0.0, 1.0, 1.0, 0.0, 1.0)] * 2)


def _spots(first: float, second: float) -> Floats:
    spots = np.zeros((2, 7))
    for i, x in enumerate((first, second)):
        set_spot(spots, i, x, 0.0, 0.0, 1.0, 0.0)
    return spots


@pytest.mark.parametrize(
    ("proposed", "mutual", "who"),
    [
        ((0.1, 1.0), True, 1),
        ((0.0, 0.9), True, 2),
        ((0.1, 0.9), True, 3),
        ((0.1, 0.9), False, 1),
        ((-0.1, 1.1), True, 0),
    ],
)
def test_who_comes_nearer_collides_and_both_are_touched(proposed: tuple[float, float], mutual: bool, who: int) -> None:
    index = np.zeros((3, 5), dtype=np.int64)
    index[:, OF_PARTS] = [0, 1, 2]
    flags = np.zeros((4, 2), dtype=np.int64)
    assert flag_collision(PARTS, index, _spots(0.0, 1.0), _spots(*proposed), 0, 1, mutual, flags) == who
    assert flags[COLLIDED].tolist() == [who & 1, who >> 1]
    assert flags[TOUCHED].tolist() == [int(who != 0)] * 2
