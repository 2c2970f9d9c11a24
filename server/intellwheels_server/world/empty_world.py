"""A world at tick 0 with no bodies."""

from __future__ import annotations

import numpy as np

from intellwheels_server.world.body_set import assemble
from intellwheels_server.world.kernels.arrays import Walls
from intellwheels_server.world.kernels.rows import FLAG_ROWS, NUMBER_ROWS
from intellwheels_server.world.state import Setup, State, no_episodes


def empty_world(setup: Setup, run: str, walls: Walls) -> State:
    """Return a world at tick 0 with no bodies.

    Args:
        setup: The map, the seed and the rules.
        run: The name of the run.
        walls: The walls of the map.
    """
    body_set, samples = assemble({}, setup, 0, None)
    return State(
        run=run,
        tick=0,
        setup=setup,
        walls=walls,
        body_set=body_set,
        numbers=np.zeros((NUMBER_ROWS, 0)),
        flags=np.zeros((FLAG_ROWS, 0), dtype=np.int64),
        samples=samples,
        episodes=no_episodes(),
    )
