"""Islands: who is settled with whom, and what is granted without looking."""

import numpy as np

from intellwheels_server.world.kernels.arrays import Floats, Shape
from intellwheels_server.world.kernels.contact_islands import (
    ISLAND_MOTION,
    ISLAND_TIGHT,
    LAST_MEMBER,
    MEMBER_COUNT,
    NEXT_MEMBER,
    REACH_MOTION,
    Neighbours,
    find_islands,
    list_members,
    neighbours_of,
    partners_of,
    reaches,
)
from intellwheels_server.world.kernels.penetration import OF_NEAR
from tests.server.world.kernels.crowds import CHAIR, Floor

# Two chairs nose to nose, a third beside them that does not move, a fourth far away.
POSES = [(0.0, 0.0, 0.0), (-1.0, 0.0, 3.0), (0.0, 0.8, 0.0), (50.0, 0.0, 0.0)]


def _floor() -> Floor:
    floor = Floor([Shape(f"chair{k}", CHAIR) for k in range(4)], POSES)
    for i in (0, 1, 3):
        floor.drive(i, 0.05, 0.0)
    return floor


def _neighbours(floor: Floor, reach: Floats) -> Neighbours:
    walls = floor.walls
    return neighbours_of(floor.bodies.shape, walls.pieces, walls.cells, walls.frame, floor.pose, reach)


def test_movers_that_could_meet_are_one_island() -> None:
    floor = _floor()
    reach = reaches(floor.bodies.shape, floor.bodies.marks, floor.twist)
    assert reach[REACH_MOTION].tolist() == [0.05, 0.05, 0.0, 0.05]
    neighbours = _neighbours(floor, reach)
    parent, island = np.empty(4, dtype=np.int64), np.empty((3, 4))
    assert find_islands(floor.bodies.shape, floor.walls.pieces, floor.pose, reach, neighbours, parent, island)
    assert parent.tolist() == [0, 0, 2, 3]
    assert island[ISLAND_TIGHT, [0, 3]].tolist() == [1.0, 0.0]
    assert island[ISLAND_MOTION, 0] == 0.05
    listed = list_members(reach, parent, island)
    assert listed[MEMBER_COUNT].tolist() == [2, 0, 0, 0]
    assert (listed[NEXT_MEMBER, 0], listed[LAST_MEMBER, 0]) == (1, 1)


def test_partners_are_mutual_and_share_their_pair() -> None:
    floor = _floor()
    reach = reaches(floor.bodies.shape, floor.bodies.marks, floor.twist)
    partners = partners_of(floor.bodies.part_start, floor.bodies.marks, _neighbours(floor, reach))
    found = {
        (i, int(partners.around[k])): int(partners.pair_of[k])
        for i in range(4)
        for k in range(partners.layout[i, OF_NEAR], partners.layout[i + 1, OF_NEAR])
    }
    assert set(found) == {(0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1)}
    assert all(found[i, j] == found[j, i] for i, j in found)
    assert sorted(set(found.values())) == [0, 1, 2]
    assert partners.pair_hit.tolist() == [-1, -1, -1]


def test_what_is_externally_posed_does_not_move() -> None:
    floor = Floor([Shape("real", CHAIR, externally_posed=True)], [(0.0, 0.0, 0.0)])
    floor.drive(0, 0.05, 0.1)
    assert reaches(floor.bodies.shape, floor.bodies.marks, floor.twist)[REACH_MOTION].tolist() == [0.0]
