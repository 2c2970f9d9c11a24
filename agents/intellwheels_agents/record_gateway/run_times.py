"""When a message of a run happened, as nanoseconds, and which ticks were missed. Pure: the time of day is an argument.

A recording has one time, which never jumps back: the simulated time of each run, counted from the time of day at which
its first message arrived, or from the end of the run before, whichever is later.
"""

from __future__ import annotations

from typing import Final

from intellwheels_schemas.messages import WorldState

LATEST: Final = (2**32 - 1) * 1_000_000_000
"""The last time that a message of Foxglove can carry, in ns."""


class RunTimes:
    """The time of a recording.

    Attributes:
        run: The current run; empty before the first message.
        now: Time of the latest message, in ns.
        period: Simulated seconds from one tick to the next; 0 while unknown.
    """

    def __init__(self) -> None:
        self.run = ""
        self.now = 0
        self.period = 0.0
        self._base = 0

    def begin(self, run: str, seconds: float, unix_time: float) -> None:
        """Begin a run.

        Args:
            run: Its id.
            seconds: Simulated time of its first message.
            unix_time: The time of day, in seconds.
        """
        wanted = _nanoseconds(unix_time) - _nanoseconds(seconds)
        self._base = max(wanted, self.now + 1 if self.run else wanted, 0)
        self.run, self.period = run, 0.0

    def at(self, seconds: float) -> int:
        """Return the time of a simulated time of the current run, in ns."""
        found = min(self._base + _nanoseconds(seconds), LATEST)
        self.now = max(self.now, found)
        return found

    def at_tick(self, tick: int) -> int:
        """Return the time of a tick of the run, in ns; that of the latest message while the period is unknown."""
        return self.at(tick * self.period) if self.period > 0.0 else self.now

    def learn_period(self, tick: int, seconds: float) -> None:
        """Learn the period from a message that has a tick and a time."""
        if tick > 0:
            self.period = seconds / tick


class Ticks:
    """Puts the parts of states together, and counts the ticks of which no state came.

    Attributes:
        seen: Ticks whose state came.
        missed: Ticks between them whose state did not come.
        last: Run and tick of the latest state.
    """

    def __init__(self) -> None:
        self.seen = 0
        self.missed = 0
        self.last = ("", -1)
        self._parts: dict[int, WorldState] = {}

    def add(self, state: WorldState) -> tuple[WorldState, ...]:
        """Return all parts of a state once the last one has come; else nothing.

        A state that came before, or an older one, gives nothing either.
        """
        if state.part >= state.parts:
            return ()
        if state.run != self.last[0]:
            self.last, self._parts = (state.run, -1), {}
        if state.tick <= self.last[1]:
            return ()
        held = next(iter(self._parts.values()), state)
        if (state.tick, state.parts) != (held.tick, held.parts):
            if state.tick < held.tick:
                return ()
            self._parts = {}
        self._parts[state.part] = state
        if len(self._parts) < state.parts:
            return ()
        if self.last[1] >= 0:
            self.missed += state.tick - self.last[1] - 1
        self.seen += 1
        self.last = (state.run, state.tick)
        whole = tuple(self._parts[part] for part in sorted(self._parts))
        self._parts = {}
        return whole


def _nanoseconds(seconds: float) -> int:
    return round(seconds * 1e9)
