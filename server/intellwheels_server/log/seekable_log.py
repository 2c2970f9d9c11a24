"""A log in which any tick can be reached, forwards and backwards.

Opening the log runs it once and keeps some of the states as keyframes. A state never changes, so a keyframe is only a
reference. To reach a tick, the log is run again from the last keyframe before it.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator
from itertools import takewhile
from pathlib import Path
from time import perf_counter
from typing import Final, NamedTuple

import msgspec

from intellwheels_schemas.messages import Event
from intellwheels_server.log.input_log import Line, LogReader, parse_line
from intellwheels_server.log.resimulate import difference, first_state, replay
from intellwheels_server.world import State, advance, apply, digest

BUDGET: Final = 0.05
"""Initial time to run the log from one keyframe to the next, in seconds."""
KEYFRAMES: Final = 1024
"""Largest number of keyframes. When there are more, every other one is dropped."""


class Place(NamedTuple):
    """A position in a log, and the state there.

    Attributes:
        position: How many lines have been run.
        state: The state as subscribers saw it, after all changes at its tick, including those in the line of its step.
        events: The events since the last place, if this is the next one.
    """

    position: int
    state: State
    events: tuple[Event, ...] = ()


class Span(NamedTuple):
    """A run of the log, and the position where it begins."""

    run: str
    first: int


class Keyframes:
    """States along a log, close enough that running it from one to the next takes only a moment.

    Args:
        budget: Approximate time to run the log from one to the next, in seconds.
        most: Keyframes kept. When there are more, every other one is dropped and the budget is doubled.
    """

    def __init__(self, budget: float = BUDGET, most: int = KEYFRAMES) -> None:
        self.budget = budget
        self._most = most
        self._positions: list[int] = []
        self._states: list[State] = []
        self._cost = 0.0

    def __len__(self) -> int:
        return len(self._states)

    def offer(self, position: int, state: State, cost: float) -> None:
        """Keep a state if a keyframe is due. Call it for every position in order, from 0.

        Args:
            position: The position.
            state: The state there.
            cost: Seconds that it took to run the line before it.
        """
        self._cost += cost
        if self._states and self._cost < self.budget:
            return
        self._positions.append(position)
        self._states.append(state)
        self._cost = 0.0
        if len(self._states) > self._most:
            self.budget *= 2.0
            del self._positions[1::2], self._states[1::2]

    def before(self, position: int) -> tuple[int, State]:
        """Return the last keyframe at or before a position, and its position."""
        i = bisect_right(self._positions, position) - 1
        return self._positions[i], self._states[i]


class SeekableLog:
    """A log that has been run once.

    Attributes:
        header: Its first line.
        cut: Whether its end is missing.
        chained: Whether its lines have checksums.
        differs: Where the first hash differs from the recorded one, as text, or None.
        end: The last position that is shown: the last step. Leaves after it are not shown.

    Args:
        path: The log; lines are read again when they are needed.
        progress: Called with the number of lines, every thousand lines.

    Raises:
        LogError: The file is no log, it is edited, or a line is missing.
        OSError: The file cannot be read.
    """

    def __init__(self, path: Path, progress: Callable[[int], None] = lambda _lines: None) -> None:
        self._name = str(path)
        self._file = path.open("rb")
        self._offsets = array("Q")
        self._ticks = array("q", [0])
        self._events: dict[str, list[Event]] = {}
        self._keyframes = Keyframes()
        self.differs: str | None = None
        self.end = 0
        try:
            reader = LogReader(self._file, self._name)
            self.header = reader.first
            self._spans = [Span(self.header.run, 0)]
            self._run_through(reader, progress)
            self.cut, self.chained = reader.cut, reader.is_chained
            # The place after all joins takes long to compute, and users return to it most often.
            self._beginning = self._with_changes(*self._keyframes.before(0), ())
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _run_through(self, reader: LogReader, progress: Callable[[int], None]) -> None:
        state = first_state(self.header, self._name)
        self._keyframes.offer(0, state, 0.0)
        offset = self._file.tell()
        for position, text in enumerate(iter(self._file.readline, b""), start=1):
            line = reader.read(text)
            if line is None:
                continue
            began = perf_counter()
            state, outputs = replay(state, line, f"{self._name}:{position + 1}")
            self._keyframes.offer(position, state, perf_counter() - began)
            self._offsets.append(offset)
            offset += len(text)
            self._ticks.append(state.tick)
            if state.run != self._spans[-1].run:
                self._spans.append(Span(state.run, position))
                self.end = position
            if line.stepped:
                self.end = position
            for event in outputs.events:
                self._events.setdefault(event.run, []).append(event)
            found = digest(state)
            if self.differs is None and found != line.hash:
                self.differs = difference(state, line, position + 1, found)
            if position % 1000 == 0:
                progress(position)
        reader.finish()

    # ------------------------------------------------------------ contents

    @property
    def last_tick(self) -> int:
        """The tick after its last line."""
        return self._ticks[-1]

    @property
    def runs(self) -> tuple[str, ...]:
        """The names of its runs, in order."""
        return tuple(span.run for span in self._spans)

    def ticks(self, run: str) -> tuple[int, int] | None:
        """Return the first and the last tick of a run, or None if it is not in the log."""
        bounds = self._bounds(run)
        return None if bounds is None else (self._ticks[bounds[0]], self._ticks[bounds[1]])

    def events(self, run: str, tick: int) -> Iterator[Event]:
        """Return the events of a run up to and including a tick."""
        return takewhile(lambda event: event.tick <= tick, self._events.get(run, ()))

    # ------------------------------------------------------------ moving

    def go_to(self, run: str, tick: int) -> Place:
        """Return the place at a tick of a run.

        Raises:
            LookupError: There is no such run or tick; the text lists those that exist.
        """
        bounds, ticks = self._bounds(run), self.ticks(run)
        if bounds is None or ticks is None:
            raise LookupError(f"expected a run of this log ({', '.join(self.runs)}), got {run}")
        if not ticks[0] <= tick <= ticks[1]:
            raise LookupError(f"run {run}: expected a tick in [{ticks[0]}, {ticks[1]}], got {tick}")
        wanted = bisect_left(self._ticks, tick, bounds[0], bounds[1] + 1)
        if wanted == 0:
            return self._beginning
        position, state = self._keyframes.before(wanted)
        while position < wanted:
            state, _ = replay(state, self._line(position), self._name)
            position += 1
        return self._with_changes(position, state, ())

    def next_place(self, place: Place) -> Place:
        """Return the place at the next tick, or where the next run begins. The place must not be at the end."""
        line = self._line(place.position)
        if line.stepped:
            state, outputs = advance(place.state, msgspec.structs.replace(line.inputs, changes=()))
        else:
            state, outputs = apply(place.state, line.inputs.changes)
        return self._with_changes(place.position + 1, state, outputs.events)

    def _with_changes(self, position: int, state: State, events: tuple[Event, ...]) -> Place:
        """Return the place with the changes of its tick made, up to its step or the beginning of another run."""
        while position < self.end:
            line = self._line(position)
            if not line.stepped and self._span(position + 1) != self._span(position):
                break
            state, outputs = apply(state, line.inputs.changes)
            events += outputs.events
            if line.stepped:
                break
            position += 1
        return Place(position, state, events)

    def _span(self, position: int) -> int:
        return bisect_right(self._spans, position, key=lambda span: span.first) - 1

    def _bounds(self, run: str) -> tuple[int, int] | None:
        """Return the first and the last position of a run."""
        for span, following in zip(self._spans, [*self._spans[1:], Span("", self.end + 1)], strict=True):
            if span.run == run:
                return span.first, following.first - 1
        return None

    def _line(self, position: int) -> Line:
        self._file.seek(self._offsets[position])
        return parse_line(self._file.readline(), f"{self._name}:{position + 2}")
