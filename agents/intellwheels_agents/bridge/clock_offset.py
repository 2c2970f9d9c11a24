"""What the hardware's clock shows when this one shows something: the quickest of the last messages says it best. Pure.

A message taken at T on their clock and arriving at t on ours tells t - T = offset + delay, and the delay is never
negative. So the least t - T of a window is nearest to the offset, however uneven the line is; the window is short
enough that clocks which run differently by 100 millionths differ by a millisecond in it.
"""

from __future__ import annotations

from collections import deque
from typing import Final

WINDOW: Final = 10.0
"""Seconds of messages that are compared."""


class ClockOffset:
    """An estimate of our clock minus theirs."""

    def __init__(self) -> None:
        # Ascending in both: what came before a quicker one will never again be the quickest.
        self._kept: deque[tuple[float, float]] = deque()
        self._theirs = float("-inf")

    def hear(self, theirs: float, ours: float) -> None:
        """Take a message: seconds on their clock when it was sent, on ours when it arrived."""
        if theirs < self._theirs - WINDOW:
            self._kept.clear()  # their clock began anew
        self._theirs = theirs
        while self._kept and self._kept[-1][1] >= ours - theirs:
            self._kept.pop()
        self._kept.append((ours, ours - theirs))
        while self._kept[0][0] < ours - WINDOW:
            self._kept.popleft()

    def renew(self) -> None:
        """Forget everything: their clock began anew."""
        self._kept.clear()
        self._theirs = float("-inf")

    def ours(self, theirs: float) -> float:
        """Return what our clock showed when theirs showed this, in seconds; something must have been heard."""
        return theirs + self._kept[0][1]
