"""The world of the current run, and the changes that its log does not hold yet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import msgspec

from intellwheels_schemas.crew_messages import alone
from intellwheels_schemas.file_records import Change, Inputs
from intellwheels_schemas.messages import Actions, Event, Result, ResultCode
from intellwheels_server import world
from intellwheels_server.world import Outcome, Outputs, State, Walls

TEXT_LIMIT = 1000
"""Characters of a text in a reply."""


class Recorder(Protocol):
    """Writes lines of the input log."""

    def __call__(self, tick: int, inputs: Inputs, digest: str, *, stepped: bool) -> None:
        """Record a line: the inputs at a tick, and the hash of the state after them."""


class RunState:
    """The world, its hash and its log.

    Attributes:
        state: The world at the current tick.

    Args:
        state: The first state.
        record: Writes the input log; None for no log.
    """

    def __init__(self, state: State, record: Recorder | None = None) -> None:
        self.state = state
        self._record = record
        self._unrecorded: list[Change] = []
        self._hashed: tuple[State, str] | None = None

    @property
    def unrecorded(self) -> tuple[Change, ...]:
        """The changes since the last recorded line, in order."""
        return tuple(self._unrecorded)

    def digest(self) -> str:
        """Return the hash of the state; it is computed once for each state."""
        if self._hashed is None or self._hashed[0] is not self.state:
            self._hashed = (self.state, world.digest(self.state))
        return self._hashed[1]

    def result(self, code: ResultCode, text: str | None = None) -> Result:
        """Return a reply to a control message or a leave, with the current run, tick and hash."""
        words = text[:TEXT_LIMIT] if text else None
        return Result(code=code, run=self.state.run, tick=self.state.tick, hash=self.digest(), text=words)

    def apply(self, change: Change, walls: Walls | None = None) -> tuple[Outcome, tuple[Event, ...]]:
        """Change the world at the current tick; return the outcome and the events.

        Args:
            change: The change.
            walls: The walls of its map, if it has one and they are cut already.
        """
        outputs = self.apply_all((change,), walls)
        return outputs.outcomes[0], outputs.events

    def apply_all(self, changes: Sequence[Change], walls: Walls | None = None) -> Outputs:
        """Change the world at the current tick; return the outcome of each change, and the events."""
        self.state, outputs = world.apply(self.state, changes, walls)
        self._unrecorded.extend(changes)
        return outputs

    def advance(self, inputs: Inputs) -> Outputs:
        """Move the world by one tick and return the outputs. `record_step` must follow."""
        self.state, outputs = world.advance(self.state, inputs)
        return outputs

    def record_step(self, tick: int, inputs: Inputs) -> None:
        """Record the step from a tick, with the changes made at that tick."""
        if self._record is not None:
            if any(type(actions) is not Actions for actions in inputs.actions.values()):
                actions = {agent: alone(actions) for agent, actions in inputs.actions.items()}
                inputs = msgspec.structs.replace(inputs, actions=actions)
            if self._unrecorded:
                inputs = msgspec.structs.replace(inputs, changes=tuple(self._unrecorded))
            self._record(tick, inputs, self.digest(), stepped=True)
        self._unrecorded.clear()

    def record_changes(self, tick: int) -> None:
        """Record the changes made at a tick from which no step follows."""
        if self._record is not None:
            self._record(tick, Inputs(changes=tuple(self._unrecorded)), self.digest(), stepped=False)
        self._unrecorded.clear()
