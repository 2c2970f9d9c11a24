"""Which measures count at once, and which only when the simulator's clock confirms them. Pure.

Anybody can put measures in an open world. One message of another run, or of a tick far ahead, would make an agent deaf
for the real ones. So such a message waits for the answer to a query, and the real ones count meanwhile. After a gap the
real ones wait too, and forged ones beside them; the clock tells them apart. A step over a few ticks counts at once, as
messages are lost now and then. But the messages of a simulator come in order: if a tick comes after a later one, the
clock is asked, and if it tells that the later one was forged, it is asked about each tick from then on.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Final, NamedTuple

from intellwheels_agents.harness_outputs import Payload
from intellwheels_schemas.codec import decode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Clock, Measures

AHEAD: Final = 3
"""Ticks by which measures may be ahead of the newest known tick. More are lost seldom, and a query costs little."""
MOST_DOUBTED: Final = 64
"""Measures that wait for the clock. The oldest make room."""


class Doubted(NamedTuple):
    """Measures that wait for the clock."""

    measures: Measures
    payload: Payload


class TickGuard:
    """The newest tick that is known of the present run.

    Attributes:
        waits: Whether a query for the clock is on its way.
        fooled: Whether the last answer of the clock told that measures had counted which were forged.
    """

    def __init__(self) -> None:
        self.waits = self.fooled = False
        self._run = ""
        self._tick = self._asked_tick = -1
        self._ahead = AHEAD
        self._strange = False
        self._asked = 0
        self._doubted: deque[Doubted] = deque(maxlen=MOST_DOUBTED)

    def begin(self, run: str, tick: int) -> None:
        """Note what the simulator itself said: the run, and a tick of it."""
        self._run, self._tick, self._strange = run, tick, False

    def counts(self, measures: Measures, payload: Payload) -> bool:
        """Return whether measures count at once. Others are kept for the clock."""
        if measures.run == self._run and measures.tick <= self._tick + self._ahead:
            self._strange = self._strange or measures.tick < self._tick
            self._tick = max(self._tick, measures.tick)
            return True
        self._doubted.append(Doubted(measures, payload))
        return False

    def asks(self) -> bool:
        """Return whether to query the clock now; it is then on its way."""
        if self.waits or not (self._doubted or self._strange):
            return False
        self.waits, self._strange, self._asked_tick = True, False, self._tick
        self._asked = len(self._doubted)
        return True

    def settle(self, answers: Sequence[Payload]) -> tuple[Clock | None, list[Payload], list[str]]:
        """Handle the answers to a query for the clock, if there are any.

        Returns the clock, if all answers agree; the waiting measures that it confirms, oldest first; and why each of
        the others does not count. The next ticks that came after the question wait for another one.
        """
        doubted, asked = list(self._doubted), self._asked
        self.waits, self.fooled, self._asked = False, False, 0
        self._doubted.clear()
        try:
            clocks = [decode(Clock, *answer, strict=False) for answer in answers]
        except WireError:
            clocks = []
        clock = agreed(clocks)
        if clock is not None and clock.run == self._run:
            self.fooled = clock.tick < self._asked_tick
            self._ahead = 0 if self.fooled else self._ahead
            # The next real ones count, whatever was forged meanwhile.
            self._tick = clock.tick if self.fooled else max(self._tick, clock.tick)
        confirmed, whys = [], []
        for number, one in enumerate(doubted):
            why = contradiction(clocks, one.measures)
            if not why:
                confirmed.append(one.payload)
            elif number >= asked and clock is not None and _is_soon(clock, one.measures):
                self._doubted.append(one)
            else:
                whys.append(why)
        return clock, confirmed, whys


def agreed(clocks: Sequence[Clock]) -> Clock | None:
    """Return the earliest of the clocks that answered, if all are of one run; None if not, or without one."""
    return min(clocks, key=lambda clock: clock.tick) if len({clock.run for clock in clocks}) == 1 else None


def _is_soon(clock: Clock, measures: Measures) -> bool:
    return measures.run == clock.run and measures.tick <= clock.tick + AHEAD


def contradiction(clocks: Sequence[Clock], measures: Measures) -> str:
    """Return in words why measures do not count; empty if all clocks that answered are in their run, at their tick."""
    clock = agreed(clocks)
    if clock is not None and clock.run == measures.run and measures.tick <= clock.tick:
        return ""
    said = ", ".join(f"run {clock.run} tick {clock.tick}" for clock in clocks) or "nothing"
    return f"the simulator said {said}, these measures run {measures.run} tick {measures.tick}"
