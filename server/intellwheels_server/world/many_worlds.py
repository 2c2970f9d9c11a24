"""Many small worlds moved as one array program, each equal to the bit to its own single run.

    worlds = stack(states)                               # states of `begin` and `apply`
    worlds, outputs = advance_many(worlds, commands=powers)
    state = worlds.state(7)                              # a state like any other

Learning and sweeps run thousands of small worlds. Most of the time of a single step is spent around its kernels. Here
the kernels run over the stacked arrays of all worlds. Python handles only the worlds in which more happens than motion:
contacts, messages, time-outs, inputs other than commands. The kernels are compiled when they are first used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
import numpy as np

from intellwheels_schemas.file_records import Inputs
from intellwheels_server.world.changes import Outputs
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints, Walls
from intellwheels_server.world.kernels.tick_many import END_HIT, FIRST_HIT, FOUND, tick_many
from intellwheels_server.world.sensors.kind import ManyViews
from intellwheels_server.world.shared_work import parts_of, share
from intellwheels_server.world.stacked_sensors import StackedSensors, layout_of, stack_sensors
from intellwheels_server.world.state import State, no_episodes
from intellwheels_server.world.step import Entered, conclude, enter, limits_of

_NOBODY = np.empty(0, dtype=np.int64)
_NO_INPUTS = Inputs()
_NO_BLOCK = np.empty((0, 0))
_NO_FLAGS = np.empty((0, 0), dtype=np.int64)
_NO_SAMPLES = np.empty(0)


class Worlds(msgspec.Struct, frozen=True, kw_only=True):
    """Many worlds, each at its own tick. They never change; a step makes new ones.

    Attributes:
        rest: Each world without its arrays, and at the tick at which anything but its arrays last changed.
        watched: bool[worlds], worlds whose next step needs Python: with contacts, messages or an end condition.
        ticks: int64[worlds].
        numbers: float64[worlds, NUMBER_ROWS, n].
        flags: int64[worlds, FLAG_ROWS, n].
        samples: float64[worlds, ...].
        fixed: The arrays of the body sets, stacked: parts, shape, marks, motors, flaws, noise, limits.
        sensors: The sensors.
    """

    rest: tuple[State, ...]
    watched: Any
    ticks: Ints
    numbers: Floats
    flags: Ints
    samples: Floats
    fixed: tuple[Any, ...]
    sensors: StackedSensors

    def __len__(self) -> int:
        return len(self.rest)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the bodies, the same in all worlds: the order of the last axes."""
        return self.rest[0].names

    @property
    def walls(self) -> Walls:
        """The walls, the same in all worlds."""
        return self.rest[0].walls

    def state(self, world: int) -> State:
        """Return the state of a world. Its arrays are views, so all worlds stay in memory as long as it."""
        return msgspec.structs.replace(
            self.rest[world],
            tick=int(self.ticks[world]),
            numbers=self.numbers[world],
            flags=self.flags[world],
            samples=self.samples[world],
        )

    def replaced(self, states: Mapping[int, State]) -> Worlds:
        """Return these worlds with some of them replaced by others, such as those that begin again.

        Args:
            states: The new states, by world.

        Raises:
            ValueError: One cannot stand beside the others: see `stack`.
        """
        numbers, flags, samples = self.numbers.copy(), self.flags.copy(), self.samples.copy()
        ticks, watched = self.ticks.copy(), self.watched.copy()
        fixed = tuple(block.copy() for block in self.fixed)
        rest = list(self.rest)
        for world, state in states.items():
            misfit = self.misfit(state)
            if misfit is not None:
                raise ValueError(f"world {world}: {misfit}")
            numbers[world], flags[world], samples[world] = state.numbers, state.flags, state.samples
            ticks[world], watched[world], rest[world] = state.tick, _is_watched(state), _without_arrays(state)
            for block, own in zip(fixed, _fixed_of(state), strict=True):
                block[world] = own
        sensors = self.sensors.replaced({world: state.body_set.plan for world, state in states.items()})
        return Worlds(
            rest=tuple(rest), watched=watched, ticks=ticks, numbers=numbers, flags=flags, samples=samples, fixed=fixed,
            sensors=sensors,
        )  # fmt: skip

    def misfit(self, state: State) -> str | None:
        """Return why a state cannot stand beside these worlds; None if it can."""
        return _misfit(self.rest[0], state)


def stack(states: Sequence[State]) -> Worlds:
    """Return worlds as one block of arrays.

    They must have the same walls and obstacles, period and `strict`, the same names of bodies, as many parts of each
    body, and on each body sensors of the same kinds, in the same order, that keep as many samples (`Every`, `Latency`).
    Anything else may differ: seeds, places and starts, ticks, sizes of bodies, motors, noise, directions and ranges of
    sensors, rules of speech, ends.

    Raises:
        ValueError: There is none, or one does not fit to the first; the text says which and why.
    """
    if not states:
        raise ValueError("states: expected at least one, got none")
    for world, state in enumerate(states):
        misfit = _misfit(states[0], state)
        if misfit is not None:
            raise ValueError(f"world {world}: {misfit}")
    return Worlds(
        rest=tuple(_without_arrays(state) for state in states),
        watched=np.array([_is_watched(state) for state in states]),
        ticks=np.array([state.tick for state in states], dtype=np.int64),
        numbers=np.stack([state.numbers for state in states]),
        flags=np.stack([state.flags for state in states]),
        samples=np.stack([state.samples for state in states]),
        fixed=tuple(np.stack(blocks) for blocks in zip(*(_fixed_of(state) for state in states), strict=True)),
        sensors=stack_sensors([state.body_set.plan for state in states], len(states[0].samples)),
    )


def advance_many(
    worlds: Worlds, inputs: Mapping[int, Inputs] | None = None, *, commands: Floats | None = None, threads: int = 1
) -> tuple[Worlds, dict[int, Outputs]]:
    """Return all worlds one tick later, and the outputs of those that have any event.

    Each world is equal to the bit to what `advance` makes of it alone, for any number of threads.

    Args:
        worlds: They are not changed.
        inputs: Inputs by world, as `advance` takes them, without changes and poses.
        commands: float64[worlds, n, 2], the powers of the left and right motors, in [-1, 1]; NaN leaves a command as
            it is. It is the same as `Actions` with these powers in `inputs`, which it precedes, and takes less time.
        threads: Threads that share the worlds. A second one pays from about 500 worlds on.

    Raises:
        ValueError: An argument does not fit.
        RuntimeError: The run of a world has ended.
    """
    count = len(worlds)
    inputs = inputs or {}
    parts = parts_of(count, threads)
    _check_inputs(worlds, inputs)
    numbers, flags, samples = worlds.numbers.copy(), worlds.flags.copy(), worlds.samples.copy()
    if commands is not None:
        _enter_commands(commands, numbers, flags)
    entered: dict[int, tuple[State, Entered]] = {}
    for world, own in inputs.items():
        state = worlds.state(world)
        entered[world] = state, enter(state, own, numbers[world], flags[world])

    summary = np.empty((3, count), dtype=np.int64)
    ticks = worlds.ticks + 1
    hits: dict[int, tuple[Ints, Floats]] = {}

    def move(first: int, end: int) -> None:
        hits[first] = _kernels(worlds, (numbers, flags, samples), ticks, summary, first, end)

    share(move, parts)
    touched = summary[END_HIT] > summary[FIRST_HIT]
    eventful = worlds.watched | (summary[FOUND] != 0) | touched
    for world, (state, left) in entered.items():
        eventful[world] |= _leaves_something(state, inputs[world], left)
    rest, watched, outputs = worlds.rest, worlds.watched, {}
    if eventful.any():
        changed, watched = list(rest), watched.copy()
        for first, end in parts:
            for world in (first + np.nonzero(eventful[first:end])[0]).tolist():
                state, left = entered.get(world) or _untouched(worlds, world)
                found, begin, stop = summary[:, world].tolist()
                pairs, pair_numbers = hits[first]
                after = numbers[world], flags[world], samples[world]
                of_kernels = found, pairs[begin:stop], pair_numbers[begin:stop]
                new, events, ended = conclude(state, inputs.get(world, _NO_INPUTS), left, of_kernels, after)
                changed[world], watched[world] = _without_arrays(new), _is_watched(new)
                if events or ended:
                    outputs[world] = Outputs(events=events, ended=ended)
        rest = tuple(changed)
    return msgspec.structs.replace(
        worlds, rest=rest, watched=watched, ticks=ticks, numbers=numbers, flags=flags, samples=samples
    ), outputs


def _kernels(
    worlds: Worlds, arrays: tuple[Floats, Ints, Floats], ticks: Ints, summary: Ints, first: int, end: int
) -> tuple[Ints, Floats]:
    """Move and sense the worlds from `first` to before `end`; return the pairs that touched, and their numbers."""
    numbers, flags, samples = arrays
    parts, shape, marks, motors, flaws, noise, limits = worlds.fixed
    setup, walls = worlds.rest[0].setup, worlds.walls
    part_start = worlds.rest[0].body_set.bodies.part_start
    found: tuple[Ints, Floats] = tick_many(
        parts, part_start, shape, marks, *walls, motors, flaws, noise, limits, numbers, flags, _NOBODY, worlds.ticks,
        setup.period, *limits_of(setup), summary, first, end,
    )  # fmt: skip
    worlds.sensors.take(ticks, ManyViews(numbers, parts, part_start, walls, setup.period), samples, first, end)
    return found


def _enter_commands(commands: Floats, numbers: Floats, flags: Ints) -> None:
    count, _, bodies = numbers.shape
    if not isinstance(commands, np.ndarray) or commands.shape != (count, bodies, 2) or commands.dtype != np.float64:
        got = f"{commands.dtype}{list(commands.shape)}" if isinstance(commands, np.ndarray) else repr(commands)
        raise ValueError(f"commands: expected float64[{count}, {bodies}, 2], got {got}")
    if bool((np.abs(commands) > 1.0).any()):
        world, body, side = np.argwhere(np.abs(commands) > 1.0)[0].tolist()
        raise ValueError(
            f"commands[{world}, {body}, {side}]: expected a power in [-1, 1], got {commands[world, body, side]:g}"
        )
    given = ~np.isnan(commands)
    powers = numbers[:, rows.LEFT_COMMAND : rows.RIGHT_COMMAND + 1]
    np.copyto(powers, commands.transpose(0, 2, 1), where=given.transpose(0, 2, 1))
    np.copyto(flags[:, rows.COMMAND_AGE], 0, where=given.any(axis=2))


def _check_inputs(worlds: Worlds, inputs: Mapping[int, Inputs]) -> None:
    for world, own in inputs.items():
        if not 0 <= world < len(worlds):
            raise ValueError(f"inputs: expected worlds from 0 to {len(worlds) - 1}, got {world}")
        if own.changes or own.poses:
            field = "changes" if own.changes else "poses"
            raise ValueError(
                f"inputs[{world}]: expected no {field}, got some: use `advance` for this world, and `replaced`"
            )
    for world in np.nonzero(worlds.watched)[0].tolist():
        state = worlds.rest[world]
        if state.ended:
            raise RuntimeError(f"world {world}: run {state.run} ended at tick {int(worlds.ticks[world])}")


def _leaves_something(state: State, inputs: Inputs, entered: Entered) -> bool:
    """Return whether inputs changed anything but arrays."""
    return bool(
        entered.statuses is not state.statuses
        or entered.said
        or inputs.says
        or entered.user is not state.user
        or entered.happenings
    )


def _untouched(worlds: Worlds, world: int) -> tuple[State, Entered]:
    state = worlds.state(world)
    return state, Entered(state.statuses, [], state.user, state.forwarded, _NOBODY, [])


def _is_watched(state: State) -> bool:
    return bool(
        len(state.episodes) or state.heard or state.coming or state.spoken or state.setup.end is not None or state.ended
    )


def _without_arrays(state: State) -> State:
    """Return a state without its arrays, which would keep those of all worlds of its tick in memory."""
    episodes = state.episodes.copy() if len(state.episodes) else no_episodes()
    return msgspec.structs.replace(state, numbers=_NO_BLOCK, flags=_NO_FLAGS, samples=_NO_SAMPLES, episodes=episodes)


def _fixed_of(state: State) -> tuple[Any, ...]:
    bodies, body_set = state.body_set.bodies, state.body_set
    return (
        bodies.parts, bodies.shape, bodies.marks, body_set.motors, body_set.flaws, body_set.noise, body_set.limits,
    )  # fmt: skip


def _misfit(first: State, state: State) -> str | None:
    """Return why a state cannot be stacked onto the first one; None if it can."""
    if state.ended:
        return "expected a run that goes on, got one that ended"
    for what in ("period", "strict"):
        wanted, got = getattr(first.setup, what), getattr(state.setup, what)
        if wanted != got:
            return f"expected the {what} of the first world, {wanted}, got {got}"
    if state.names != first.names:
        return f"expected bodies {', '.join(first.names)}, got {', '.join(state.names)}"
    if state.walls is not first.walls and not all(map(np.array_equal, state.walls, first.walls)):
        return "expected the walls of the first world, got others"
    if not np.array_equal(state.body_set.bodies.part_start, first.body_set.bodies.part_start):
        return "expected as many parts of each body as in the first world, got others"
    if state.body_set is not first.body_set and layout_of(state.body_set.plan) != layout_of(first.body_set.plan):
        return "expected sensors laid out as in the first world, got others"
    return None
