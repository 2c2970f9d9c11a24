"""A folder with a file of each run: its input log, and its trace.

A world that is reset goes on in the same process; here each of its runs stands alone. Its log begins with the bodies
joining where they stand, so that running it again needs nothing of the runs before. A run that began from a saved
state has no such beginning and no log, a trace only. What was never stepped leaves no file.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import IO, Final

import msgspec

from intellwheels_schemas.messages import Event
from intellwheels_server.log.input_log import Line, Log
from intellwheels_server.log.true_trace import heading_of, moment_of
from intellwheels_server.world.inputs import Inputs, Join
from intellwheels_server.world.state import State

LOG: Final = "input.jsonl"
TRACE: Final = "trace.jsonl"


class RunFiles:
    """The files of the run that goes on, each a line a tick.

    Args:
        folder: Made if it is not there; each run has a folder of its name in it.
        world: The world's name.
        state: Returns the state as it is.
    """

    def __init__(self, folder: Path, world: str, state: Callable[[], State]) -> None:
        self._folder = folder
        self._world = world
        self._state = state
        self._run = ""
        self._waiting: tuple[State, str] | None = None
        self._log: Log | None = None
        self._trace: IO[bytes] | None = None
        self._events: list[Event] = []
        self._time = 0.0

    def happened(self, event: Event) -> None:
        """Keep an event for the line of its tick."""
        self._events.append(event)

    def record(self, tick: int, inputs: Inputs, digest: str, *, stepped: bool) -> None:
        """Take a line of the input log, which has been acted on."""
        state = self._state()
        if not stepped:
            if state.run != self._run:
                self.close()
                self._waiting = (state, digest)
            return
        if state.run != self._run:
            self._open(state)
        self._time += state.setup.period
        if self._log is not None:
            self._log.write(Line(tick=tick, inputs=inputs, hash=digest), self._time)
        self._put(state, digest)
        if state.ended:
            self.close()

    def close(self) -> None:
        """End the files of this run."""
        if self._log is not None:
            self._log.close()
        if self._trace is not None:
            self._trace.close()
        self._log = self._trace = None
        self._events.clear()

    def _open(self, state: State) -> None:
        self.close()
        self._run = state.run
        place = self._folder / state.run
        place.mkdir(parents=True, exist_ok=True)
        self._trace = (place / TRACE).open("wb")
        self._trace.write(msgspec.json.encode(heading_of(state)) + b"\n")
        waiting, self._waiting = self._waiting, None
        if waiting is None or waiting[0].run != state.run:
            # Who joins before the first step is in its line.
            self._log = Log(place / LOG, state.setup, state.run, self._world)
            return
        first, hashed = waiting
        if first.tick == 0:
            self._log = Log(place / LOG, first.setup, first.run, self._world)
            self._log.write(Line(tick=0, inputs=Inputs(changes=_joins(first)), hash=hashed, stepped=False), self._time)
        self._put(first, hashed)

    def _put(self, state: State, digest: str) -> None:
        if self._trace is not None:
            events = tuple(event for event in self._events if event.run == state.run and event.tick <= state.tick)
            self._events.clear()
            self._trace.write(msgspec.json.encode(moment_of(state, digest, events)) + b"\n")


def _joins(state: State) -> tuple[Join, ...]:
    """Return how those who are here would join where they started."""
    joins = []
    for name in state.names:
        figure = state.body_set.figures[name]
        robot = msgspec.structs.replace(figure.robot, position=figure.start, place=None)
        joins.append(Join(agent=name, robot=robot))
        if figure.mind_input:
            mind = msgspec.structs.replace(robot, role="mind", user_input=figure.mind_input)
            joins.append(Join(agent=name, robot=mind))
    return tuple(joins)
