"""The world: a pure function from a state and what was latched to the next state and what came out.

    state = begin(setup, run)
    state, outputs = apply(state, changes)      # at this tick: joins, leaves, teleports, reset; no time passes
    state, outputs = advance(state, inputs)     # changes, then one step to the next tick

No clock, no files, no network, no randomness but what follows from the seed: the same inputs give the same
states, to the bit, on every machine. The service, re-simulation and experiments in one process all use these
functions and nothing else to move the world.

Example:
    A chair of the library drives forward for a second.

    >>> from intellwheels_maps import floor, robot
    >>> from intellwheels_schemas.messages import Actions
    >>> from intellwheels_server.world.inputs import Inputs, Join
    >>> from intellwheels_server.world import Setup, advance, apply, begin, measures
    >>> state = begin(Setup(floor=floor("room"), seed="1"), run="0123456789abcdef")
    >>> state, outputs = apply(state, [Join(agent="chair1", robot=robot("rear-wheel"))])
    >>> outputs.outcomes[0].code
    'ok'
    >>> for _ in range(20):
    ...     state, outputs = advance(state, Inputs(actions={"chair1": Actions(left_motor=0.5, right_motor=0.5)}))
    >>> state.tick, measures(state, "chair1").time
    (20, 1.0)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from intellwheels_server.world.body_set import assemble
from intellwheels_server.world.changes import Outcome, Outputs, change
from intellwheels_server.world.digest import digest, map_hash
from intellwheels_server.world.ending import check_end
from intellwheels_server.world.inputs import Change, Inputs
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.map_geometry import walls_of
from intellwheels_server.world.observations import entities, measures, power_in_force
from intellwheels_server.world.state import Setup, State, no_episodes
from intellwheels_server.world.step import step

__all__ = [
    "Outcome",
    "Outputs",
    "Setup",
    "State",
    "advance",
    "apply",
    "begin",
    "digest",
    "entities",
    "map_hash",
    "measures",
    "power_in_force",
]


def begin(setup: Setup, run: str) -> State:
    """Return a world at tick 0 with nobody in it.

    Args:
        setup: The floor, the seed and the rules.
        run: Name of the run, 16 hex digits, on all that is published.

    Raises:
        ValueError: The floor has a wall that is no polygon or line.
        RequestRefusedError: The end names a place that the floor has not.
    """
    if setup.end is not None:
        check_end(setup.end, setup.floor)
    walls = walls_of(setup.floor)
    body_set, samples = assemble({}, setup, 0, None)
    return State(
        run=run,
        tick=0,
        setup=setup,
        walls=walls,
        body_set=body_set,
        numbers=np.zeros((rows.NUMBER_ROWS, 0)),
        flags=np.zeros((rows.FLAG_ROWS, 0), dtype=np.int64),
        samples=samples,
        episodes=no_episodes(),
    )


def apply(state: State, changes: Sequence[Change]) -> tuple[State, Outputs]:
    """Return the state after changes at its tick, sensed anew, and what became of each change.

    Args:
        state: Is not changed.
        changes: Made in this order.
    """
    if not changes:
        return state, Outputs()
    return change(state, changes)


def advance(state: State, inputs: Inputs) -> tuple[State, Outputs]:
    """Return the state one tick later, and what came out.

    Args:
        state: Is not changed.
        inputs: Changes are made first; all else acts on the step.

    Raises:
        RuntimeError: The run has ended; a `GoOn` among the changes, or a `Restart`, goes on.
    """
    state, before = apply(state, inputs.changes)
    if state.ended:
        raise RuntimeError(f"run {state.run} ended at tick {state.tick}: expected GoOn or Restart before another step")
    state, events, ended = step(state, inputs)
    return state, Outputs(outcomes=before.outcomes, events=before.events + events, ended=ended)
