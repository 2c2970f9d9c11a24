"""A state while it is being changed, before its arrays are built again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import msgspec
import numpy as np

from intellwheels_schemas.messages import Event, EventCode, Position
from intellwheels_server.world.body_set import BodyModel, BodySet, assemble
from intellwheels_server.world.kernels.arrays import Floats, Ints, Walls
from intellwheels_server.world.kernels.rows import FLAG_ROWS, HEADING, NUMBER_ROWS, POSE_AGE, SILENT, X, Y
from intellwheels_server.world.placement import OccupiedSpace
from intellwheels_server.world.sensors import sense
from intellwheels_server.world.sensors.kind import View
from intellwheels_server.world.state import State


class Draft:
    """A state being changed. Each body has columns of its own, which `finish` sorts by name and puts together.

    Attributes:
        state: Everything that is not kept by body. Its bodies and arrays are those before the changes.
        models: The bodies, by name.
        numbers: float64[NUMBER_ROWS] of each body.
        flags: int64[FLAG_ROWS] of each body.
        events: The events.
        new_walls: The walls of a map that a change brings, if they are known already.
    """

    def __init__(self, state: State, new_walls: Walls | None = None) -> None:
        self.events: list[Event] = []
        self.new_walls = new_walls
        self.replace_state(state)

    def replace_state(self, state: State) -> None:
        """Continue from another state. The events so far are kept."""
        self.state = state
        self.models: dict[str, BodyModel] = dict(state.body_set.models)
        self.numbers: dict[str, Floats] = dict(zip(state.names, state.numbers.T.copy(), strict=True))
        self.flags: dict[str, Ints] = dict(zip(state.names, state.flags.T.copy(), strict=True))
        self._bodies_changed = False
        self._arrived: set[str] = set()
        self._space: OccupiedSpace | None = None

    @property
    def space(self) -> OccupiedSpace:
        """The space that walls and bodies occupy."""
        if self._space is None:
            self._space = OccupiedSpace(self.state.walls, self.state.setup.floor)
            for name, model in self.models.items():
                numbers = self.numbers[name]
                self._space.add(name, model, numbers[X], numbers[Y], numbers[HEADING])
        return self._space

    def update(self, **fields: object) -> None:
        """Replace fields of the state."""
        self.state = msgspec.structs.replace(self.state, **fields)

    def event(
        self, code: EventCode, agent: str | None = None, text: str | None = None, speed: float | None = None
    ) -> None:
        """Add an event."""
        state = self.state
        self.events.append(
            Event(
                run=state.run,
                tick=state.tick,
                number=state.event_count,
                code=code,
                agent=agent,
                speed=speed,
                text=text or None,
            )
        )
        self.update(event_count=state.event_count + 1)

    def put(self, name: str, model: BodyModel, position: Position) -> None:
        """Add a body at rest. It replaces a body of the same name."""
        numbers = np.zeros(NUMBER_ROWS)
        numbers[X], numbers[Y], numbers[HEADING] = position.x, position.y, position.heading
        flags = np.zeros(FLAG_ROWS, dtype=np.int64)
        flags[SILENT] = 1
        flags[POSE_AGE] = 1 if model.externally_posed else 0  # its start counts as its pose at this tick
        self.models[name] = model
        self.numbers[name] = numbers
        self.flags[name] = flags
        self._bodies_changed = True
        self._arrived.add(name)
        self.space.add(name, model, position.x, position.y, position.heading)

    def replace_model(self, name: str, model: BodyModel) -> None:
        """Change the model of a body that stays where it is."""
        self.models[name] = model
        self._bodies_changed = True

    def remove(self, name: str) -> None:
        """Remove a body and everything that belongs to it."""
        key = self.models[name].key
        del self.models[name], self.numbers[name], self.flags[name]
        state, episodes = self.state, self.state.episodes
        self.update(
            statuses=_without(state.statuses, name),
            user=_without(state.user, name),
            forwarded=_without(state.forwarded, name),
            episodes=episodes[(episodes[:, 0] != key) & (episodes[:, 1] != key)],
        )
        if self._space is not None:
            self._space.remove(name)
        self._bodies_changed = True

    def finish(self) -> State:
        """Return the changed state, with bodies sorted by name and sensors sampled."""
        state, body_set, samples = self.state, self.state.body_set, self.state.samples
        if self._bodies_changed:
            body_set, samples = assemble(self.models, state.setup, state.tick, state, self._arrived)
        numbers, flags = _columns(body_set, self.numbers, self.flags)
        view = View(numbers, body_set.bodies.parts, body_set.bodies.part_start, state.walls, state.setup.period)
        return msgspec.structs.replace(
            state,
            body_set=body_set,
            numbers=numbers,
            flags=flags,
            samples=sense(body_set.plan, view, state.tick, samples),
        )


_T = TypeVar("_T")
_A = TypeVar("_A", Floats, Ints)


def _without(entries: dict[str, _T], name: str) -> dict[str, _T]:
    return {key: value for key, value in entries.items() if key != name}


def _columns(body_set: BodySet, numbers: dict[str, Floats], flags: dict[str, Ints]) -> tuple[Floats, Ints]:
    return (
        _side_by_side([numbers[name] for name in body_set.names], np.empty((NUMBER_ROWS, 0))),
        _side_by_side([flags[name] for name in body_set.names], np.empty((FLAG_ROWS, 0), dtype=np.int64)),
    )


def _side_by_side(columns: Sequence[_A], none: _A) -> _A:
    return np.ascontiguousarray(np.concatenate(columns).reshape(len(columns), -1).T) if columns else none
