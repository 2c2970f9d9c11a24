"""The world: a pure function from a state and its inputs to the next state and its outputs.

    state = begin(setup, run)
    state, outputs = apply(state, changes)      # at this tick: joins, leaves, teleports, reset; no time passes
    state, outputs = advance(state, inputs)     # changes, then one step to the next tick

It uses no clock, no file, no network, and no randomness except what follows from the seed: the same inputs give the
same states, to the bit, on every machine. The service, re-simulation and experiments in one process move the world
with these functions only.

Example:
    An included chair drives forward for a second.

    >>> from intellwheels_maps import floor, robot
    >>> from intellwheels_schemas.messages import Actions
    >>> from intellwheels_schemas.file_records import Inputs, Join
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

from intellwheels_schemas.file_records import Change, Inputs
from intellwheels_server.world.changes import Outcome, Outputs, change
from intellwheels_server.world.digest import digest, map_hash
from intellwheels_server.world.empty_world import empty_world
from intellwheels_server.world.ending import check_end
from intellwheels_server.world.kernels.arrays import Walls
from intellwheels_server.world.map_geometry import walls_of
from intellwheels_server.world.observations import entities, measures, power_in_force
from intellwheels_server.world.state import Setup, State
from intellwheels_server.world.step import step

__all__ = [
    "Outcome",
    "Outputs",
    "Setup",
    "State",
    "Walls",
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
    """Return a world at tick 0 with no bodies.

    Args:
        setup: The map, the seed and the rules.
        run: The name of the run, 16 hex digits, in everything that is published.

    Raises:
        ValueError: A wall of the map is no polygon or line.
        RequestRefusedError: The end condition names a place that the map does not have.
    """
    if setup.end is not None:
        check_end(setup.end, setup.floor)
    return empty_world(setup, run, walls_of(setup.floor))


def apply(state: State, changes: Sequence[Change], walls: Walls | None = None) -> tuple[State, Outputs]:
    """Return the state after changes at its tick, with sensors sampled, and the outcome of each change.

    Args:
        state: Is not changed.
        changes: They are made in this order.
        walls: `walls_of` the map of a `Restart` among them, if it is known already: cutting walls takes time.
    """
    if not changes:
        return state, Outputs()
    return change(state, changes, walls)


def advance(state: State, inputs: Inputs, *, threads: int = 1) -> tuple[State, Outputs]:
    """Return the state one tick later, and the outputs.

    Args:
        state: Is not changed.
        inputs: Its changes are made first; everything else acts on the step.
        threads: Threads that share the proximity sensors of 200 bodies or more. The state is equal to the bit for any
            number of them.

    Raises:
        RuntimeError: The run has ended, and the changes have no `GoOn` or `Restart`.
    """
    before = None
    if inputs.changes:
        state, before = apply(state, inputs.changes)
    if state.ended:
        raise RuntimeError(f"run {state.run} ended at tick {state.tick}: expected GoOn or Restart before another step")
    state, events, ended = step(state, inputs, threads)
    if before is None:
        return state, Outputs(events=events, ended=ended)
    return state, Outputs(outcomes=before.outcomes, events=before.events + events, ended=ended)
