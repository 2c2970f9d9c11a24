"""One step of many worlds gives the hits of each in its own place."""

from __future__ import annotations

from typing import Any

import numpy as np

from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.tick_kernel import tick_all
from intellwheels_server.world.kernels.tick_many import END_HIT, FIRST_HIT, FOUND, tick_many
from tests.server.worlds import box_wall, cart, world

NOBODY = np.empty(0, dtype=np.int64)


def test_hits_are_listed_world_by_world_however_many_there_are() -> None:
    walls = [box_wall(1.0, -5.0, 1.2, 5.0)]
    state = world({"a": cart(), "b": cart(y=2.0)}, walls)
    bodies, body_set, count = state.body_set.bodies, state.body_set, 30
    near = np.arange(count) % 2 == 1  # every other world is at the wall
    numbers, flags = np.stack([state.numbers] * count), np.stack([state.flags] * count)
    numbers[near, rows.X] = 0.4999
    numbers[:, rows.LEFT_COMMAND : rows.RIGHT_COMMAND + 1] = 1.0
    alone = [
        tick_all(
            *(*bodies, *state.walls), body_set.motors, body_set.flaws, body_set.noise, body_set.limits,
            numbers[k].copy(), flags[k].copy(), NOBODY, k, 0.05, -1, -1,
        )
        for k in range(count)
    ]  # fmt: skip
    shapes: Any = (bodies.parts, bodies.shape, bodies.marks)
    parts, shape, marks = (np.stack([block] * count) for block in shapes)
    own: Any = (body_set.motors, body_set.flaws, body_set.noise, body_set.limits)
    fixed = [np.stack([block] * count) for block in own]
    summary = np.full((3, count), -1, dtype=np.int64)
    arguments: Any = (
        parts, bodies.part_start, shape, marks, *state.walls, *fixed, numbers, flags, NOBODY, np.arange(count), 0.05,
        -1, -1, summary, 2, count,
    )  # fmt: skip
    hits, hit_numbers = tick_many(*arguments)
    assert summary[:, :2].tolist() == [[-1, -1]] * 3
    assert len(hits) == 28  # more than there is room for at first
    for k in range(2, count):
        found, touched, touched_numbers = alone[k]
        assert summary[FOUND, k] == found
        place = slice(summary[FIRST_HIT, k], summary[END_HIT, k])
        assert hits[place].tolist() == touched.tolist()
        assert hit_numbers[place].tolist() == touched_numbers.tolist()
