"""Which measures count at once, and which only when the simulator's clock confirms them. Pure.

Anybody can put measures in an open world. One message of another run, or of a tick far ahead, would make an agent deaf
for the real ones. So such a message waits for the answer to a query, and the real ones count meanwhile.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

from intellwheels_agents.harness_outputs import Payload
from intellwheels_schemas.messages import Clock, Measures

AHEAD: Final = 3
"""Ticks by which measures may be ahead of the newest known tick. More are lost seldom, and a query costs little."""


class Doubted(NamedTuple):
    """Measures that wait for the clock."""

    measures: Measures
    payload: Payload


class TickGuard:
    """The newest tick that is known of the present run.

    Attributes:
        waits: Whether a query for the clock is on its way.
    """

    def __init__(self) -> None:
        self.waits = False
        self._run = ""
        self._tick = -1
        self._doubted: Doubted | None = None

    def begin(self, run: str, tick: int) -> None:
        """Note what the simulator itself said: the run, and a tick of it."""
        self._run, self._tick = run, tick

    def counts(self, measures: Measures, payload: Payload) -> bool:
        """Return whether measures count at once. Others are kept for the clock; the newest of them stay."""
        if measures.run == self._run and measures.tick <= self._tick + AHEAD:
            self._tick = max(self._tick, measures.tick)
            return True
        self._doubted = Doubted(measures, payload)
        return False

    def asks(self) -> bool:
        """Return whether to query the clock now; it is then on its way."""
        if self._doubted is None or self.waits:
            return False
        self.waits = True
        return True

    def take_doubted(self) -> Doubted | None:
        """Return the measures that waited, once: the clock has answered, or nobody has."""
        doubted, self._doubted, self.waits = self._doubted, None, False
        return doubted


def contradiction(clocks: Sequence[Clock], measures: Measures) -> str:
    """Return in words why measures do not count; empty if all clocks that answered are in their run, at their tick."""
    if clocks and all(clock.run == measures.run and measures.tick <= clock.tick + AHEAD for clock in clocks):
        return ""
    said = ", ".join(f"run {clock.run} tick {clock.tick}" for clock in clocks) or "nothing"
    return f"the simulator said {said}, these measures run {measures.run} tick {measures.tick}"
