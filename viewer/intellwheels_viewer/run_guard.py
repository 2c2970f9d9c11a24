"""Which messages of a world count at once, and which only after the simulator's clock confirmed their run. Pure.

Anybody can put a state, a clock or an event in an open world. Messages of another run, or of a tick far ahead, are
dropped until a query for the clock has told where the simulator is. What the simulator answers always counts.
"""

from __future__ import annotations

from typing import Final, Protocol

AHEAD: Final = 1000
"""Ticks by which a message may be ahead of the newest one. A run that does not wait makes some hundred in between."""


class Dated(Protocol):
    """A message with its run and tick."""

    @property
    def run(self) -> str:
        """The run."""

    @property
    def tick(self) -> int:
        """The tick."""


class RunGuard:
    """The run in which the simulator said it is, and the newest tick of it.

    Attributes:
        doubts: Whether a message was dropped since the last confirmation, so that the clock must be asked for.
    """

    def __init__(self) -> None:
        self.doubts = False
        self._run = ""
        self._tick = -1

    def confirm(self, clock: Dated) -> None:
        """Take the answer of the simulator."""
        self._run, self._tick, self.doubts = clock.run, clock.tick, False

    def counts(self, message: Dated) -> bool:
        """Return whether a message counts at once; if not, it is dropped."""
        if message.run != self._run or message.tick > self._tick + AHEAD:
            self.doubts = True
            return False
        self._tick = max(self._tick, message.tick)
        return True
