"""Sensors of many worlds: what can be stacked, and what is sampled one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from intellwheels_schemas.messages import Bumper, Encoders, Proximity, Robot
from intellwheels_server.world import State
from intellwheels_server.world.kernels.rows import X
from intellwheels_server.world.sensors import sense
from intellwheels_server.world.sensors.kind import ManyViews, View
from intellwheels_server.world.stacked_sensors import layout_of, stack_sensors
from tests.server.worlds import box_wall, cart, world

WALLS = [box_wall(4.0, -9.0, 5.0, 9.0)]
SONAR = Proximity(
    id="s", x=0.5, y=0.0, z=0.4, direction_deg=0.0, cone_deg=30.0, max_range=4.0, model="sonar", every=2, latency=1
)


def chair(direction: float = 0.0, **fields: Any) -> Robot:
    wedge = Proximity(id="p", x=0.5, y=0.0, z=0.4, direction_deg=direction, cone_deg=30.0, max_range=4.0)
    return cart(**{"proximity": (wedge,), **fields})


@pytest.mark.parametrize("fields", [{}, {"bumper": (Bumper(id="b"),)}, {"proximity": (SONAR,)}])
def test_samples_of_every_world_are_its_own(fields: dict[str, Any]) -> None:
    states = [world({"a": chair(10.0 * k, **fields)}, WALLS, seed=str(k)) for k in range(3)]
    for k, state in enumerate(states):
        state.numbers[X] = 0.5 * k
    first = states[0]
    stacked = stack_sensors([state.body_set.plan for state in states], len(first.samples))
    numbers = np.stack([state.numbers for state in states])
    samples = np.stack([state.samples for state in states])
    bodies = first.body_set.bodies
    views = ManyViews(numbers, np.stack([bodies.parts] * 3), bodies.part_start, first.walls, 0.05)
    stacked.take(np.array([1, 2, 3]), views, samples, 1, 3)
    assert samples[0].tolist() == first.samples.tolist()  # only the second and the third were asked for
    for k in (1, 2):
        view = View(numbers[k], bodies.parts, bodies.part_start, first.walls, 0.05)
        assert samples[k].tolist() == sense(states[k].body_set.plan, view, k + 1, states[k].samples).tolist()


def test_layout_is_that_of_samples_and_not_of_directions() -> None:
    def layout(state: State) -> tuple[object, ...]:
        return layout_of(state.body_set.plan)

    one = layout(world({"a": chair()}, WALLS))
    assert layout(world({"a": chair(90.0)}, WALLS)) == one
    assert layout(world({"a": chair(encoders=(Encoders(id="e"),))}, WALLS)) != one
    assert layout(world({"a": chair(proximity=(SONAR,))}, WALLS)) != one
