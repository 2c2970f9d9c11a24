"""What is gathered about a place is all that lies within reach, and no body twice."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from shapely.geometry import Point, Polygon

from intellwheels_server.world.kernels.grid_search import Place
from intellwheels_server.world.kernels.spatial_query import (
    LANES,
    gather_bodies,
    gather_walls,
    place_bodies,
    room_for,
)
from tests.server.world.kernels.crowds import random_floor

# Type checkers count the arguments of a kernel and not those of a starred tuple.
GATHER_BODIES: Any = gather_bodies
GATHER_WALLS: Any = gather_walls


@pytest.mark.parametrize("seed", range(4))
def test_all_within_reach_is_gathered_bodies_first_and_without_the_owner(seed: int) -> None:
    random = np.random.default_rng(seed)
    floor = random_floor(random, 30)
    walls, bodies = floor.walls, floor.bodies
    placed = place_bodies(floor.pose, bodies.parts, bodies.part_start)
    nearby, boxes = room_for(placed, walls), placed.boxes
    around, polygons, solids, _, found_places, _ = nearby
    for owner in range(5):
        x, y, reach = floor.pose[0, owner], floor.pose[1, owner], 2.0
        place = Place(x, y, reach, owner, owner)
        people = GATHER_BODIES(place, *placed, around, found_places)
        near, polygon_count = GATHER_WALLS(place, *walls, people, *nearby)
        assert near % LANES == 0
        found = [tuple(column) for column in around[:, :people].T]
        assert len(set(found)) == people
        for body in range(30):
            for part in range(bodies.part_start[body], bodies.part_start[body + 1]):
                if body == owner:
                    assert tuple(boxes[part]) not in found
                elif _distance(boxes[part], x, y) <= reach:
                    assert tuple(boxes[part]) in found
        pieces = {tuple(column) for column in around[:, people:near].T} | {
            tuple(solids[p]) for p in polygons[:polygon_count]
        }
        for (first, end, _), solid in zip(walls.links, solids, strict=True):
            if Polygon(walls.edges[first:end, :2]).distance(Point(x, y)) <= reach:
                assert any(_same(solid, piece) for piece in pieces)


def _distance(box: Any, x: float, y: float) -> float:
    c, s = box[6], box[7]
    u, v = c * (x - box[0]) + s * (y - box[1]), c * (y - box[1]) - s * (x - box[0])
    return math.hypot(max(abs(u) - box[8], 0.0), max(abs(v) - box[9], 0.0))


def _same(one: Any, other: Any) -> bool:
    return bool(np.array_equal(np.asarray(one), np.asarray(other), equal_nan=True))
