"""Bodies and wall pieces within reach of a place: all of them, each once, without the owner."""

from __future__ import annotations

import numpy as np
import pytest
from shapely.geometry import Point, box

from intellwheels_server.world.kernels.grid_search import Place, bodies_near, pieces_near
from intellwheels_server.world.kernels.spatial_query import place_bodies
from tests.server.world.kernels.crowds import random_floor


@pytest.mark.parametrize("seed", range(3))
def test_what_is_within_reach_is_found_once(seed: int) -> None:
    floor = random_floor(np.random.default_rng(seed), 30)
    walls = floor.walls
    placed = place_bodies(floor.pose, floor.bodies.parts, floor.bodies.part_start)
    found, found_for = np.empty(max(30, len(walls.pieces)), np.int64), np.full(len(walls.pieces), -1, np.int64)
    for owner in range(5):
        place = Place(float(floor.pose[0, owner]), float(floor.pose[1, owner]), 2.0, owner, owner)
        middle = Point(place.x, place.y)
        count = bodies_near(place, placed.extents, placed.cell_start, placed.cell_bodies, placed.grid, found)
        near = [
            body
            for body, (x, y, dx, dy) in enumerate(placed.extents.tolist())
            if body != owner and box(x - dx, y - dy, x + dx, y + dy).distance(middle) <= 2.0
        ]
        assert sorted(found[:count].tolist()) == near
        count = pieces_near(place, walls.pieces, walls.cells, walls.frame, found, found_for)
        near = [at for at, one in enumerate(walls.pieces.tolist()) if box(*one[:4]).distance(middle) <= 2.0]
        assert sorted(found[:count].tolist()) == near
