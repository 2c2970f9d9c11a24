"""The offset between this machine's clock and the hardware's, from the fastest of the recent messages. Pure.

A message sent at T on the hardware's clock and received at t on ours gives t - T = offset + delay, and the delay is
never negative. The smallest t - T of a window is therefore closest to the offset, however much the delay varies. The
window is short: two clocks that differ by 100 parts per million drift apart by one millisecond in it.
"""

from __future__ import annotations

from collections import deque
from typing import Final

WINDOW: Final = 10.0
"""Seconds of messages that are compared."""


class ClockOffset:
    """An estimate of our clock minus the hardware's."""

    def __init__(self) -> None:
        # Ascending in both columns: a message before a faster one can never become the fastest again.
        self._window: deque[tuple[float, float]] = deque()
        self._newest = float("-inf")

    def add(self, hardware: float, ours: float) -> None:
        """Add a message: seconds on the hardware's clock when it was sent, on ours when it was received."""
        if hardware < self._newest - WINDOW:
            self._window.clear()  # the hardware's clock restarted
        self._newest = hardware
        while self._window and self._window[-1][1] >= ours - hardware:
            self._window.pop()
        self._window.append((ours, ours - hardware))
        while self._window[0][0] < ours - WINDOW:
            self._window.popleft()

    def reset(self) -> None:
        """Forget all messages, because the hardware's clock restarted."""
        self._window.clear()
        self._newest = float("-inf")

    def to_ours(self, hardware: float) -> float:
        """Return the time on our clock, in seconds, at a time of the hardware's clock. Needs one message at least."""
        return hardware + self._window[0][1]
