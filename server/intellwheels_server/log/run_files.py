"""A folder with the input log and the trace of each run.

A reset begins a new run in the same process. Here each run has its own files. Its log begins with joins of all bodies
at their present poses, so that it can be run again without the earlier runs. A run that begins from a saved state has a
trace but no log, because joins cannot describe it. A run without a step leaves no files.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Final

import msgspec

from intellwheels_schemas.file_records import Inputs, Join
from intellwheels_schemas.messages import Event
from intellwheels_server.log.input_log import Line, Log
from intellwheels_server.log.line_file import LineFile
from intellwheels_server.log.true_trace import heading_of, moment_of
from intellwheels_server.world.state import State

LOG: Final = "input.jsonl"
TRACE: Final = "trace.jsonl"


class RunFiles:
    """The files of the current run, with one line for each tick.

    Args:
        folder: Created if needed. Each run gets a folder of its name in it.
        world: The name of the world.
        state: Returns the current state.
    """

    def __init__(self, folder: Path, world: str, state: Callable[[], State]) -> None:
        self._folder = folder
        self._world = world
        self._state = state
        self._run = ""
        self._waiting: tuple[State, str] | None = None
        self._log: Log | None = None
        self._trace: LineFile | None = None
        self._events: list[Event] = []

    def add_event(self, event: Event) -> None:
        """Add an event to the line of its tick."""
        self._events.append(event)

    def record(self, tick: int, inputs: Inputs, digest: str, *, stepped: bool) -> None:
        """Add a line to the input log and to the trace. The state is the one after the line.

        Raises:
            OSError: A file cannot be opened or closed.
        """
        state = self._state()
        if not stepped:
            if state.run != self._run:
                self.close()
                self._waiting = (state, digest)
            return
        if state.run != self._run:
            self._open(state)
        if self._log is not None:
            self._log.add(Line(tick=tick, inputs=inputs, hash=digest))
        self._put(state, digest)
        if state.ended:
            self.close()

    def flush_if_due(self, now: float) -> None:
        """Write what is buffered if it is time.

        Raises:
            OSError: A file cannot be written.
        """
        for each in (self._log, self._trace):
            if each is not None:
                each.flush_if_due(now)

    def close(self, *, orderly: bool = True) -> None:
        """Close the files of this run. Without `orderly`, its log is left as a cut one.

        Raises:
            OSError: A file cannot be written.
        """
        log, trace = self._log, self._trace
        self._log = self._trace = None
        self._events.clear()
        with contextlib.ExitStack() as stack:
            if trace is not None:
                stack.callback(trace.close)
            if log is not None:
                stack.callback(log.close, orderly=orderly)

    def _open(self, state: State) -> None:
        self.close()
        self._run = state.run
        place = self._folder / state.run
        place.mkdir(parents=True, exist_ok=True)
        self._trace = LineFile(place / TRACE)
        self._trace.add(msgspec.json.encode(heading_of(state)))
        waiting, self._waiting = self._waiting, None
        if waiting is None or waiting[0].run != state.run:
            # Joins before the first step are in the line of that step.
            self._log = Log(place / LOG, state.setup, state.run, self._world)
            return
        first, hashed = waiting
        if first.tick == 0:
            self._log = Log(place / LOG, first.setup, first.run, self._world)
            self._log.add(Line(tick=0, inputs=Inputs(changes=_joins(first)), hash=hashed, stepped=False))
        self._put(first, hashed)

    def _put(self, state: State, digest: str) -> None:
        if self._trace is not None:
            events = tuple(event for event in self._events if event.run == state.run and event.tick <= state.tick)
            self._events.clear()
            self._trace.add(msgspec.json.encode(moment_of(state, digest, events)))


def _joins(state: State) -> tuple[Join, ...]:
    """Return joins that put all bodies where they started."""
    joins = []
    for name in state.names:
        model = state.body_set.models[name]
        robot = msgspec.structs.replace(model.robot, position=model.start, place=None)
        joins.append(Join(agent=name, robot=robot))
        if model.mind_input:
            mind = msgspec.structs.replace(robot, role="mind", user_input=model.mind_input)
            joins.append(Join(agent=name, robot=mind))
    return tuple(joins)
