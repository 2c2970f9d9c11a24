"""Whether the chair drives as it was told, from the joystick values that it reports as sent to its motors. Pure.

LUCI scales an override down near obstacles, and never up. So each axis that it reports lies between 0 and a value that
was sent lately. A chair that drives otherwise has another centre of the joystick, or another program steers it too.
"""

from __future__ import annotations

from collections import deque
from typing import Final

MEMORY: Final = 0.5
"""Seconds for which a sent value explains what the chair reports."""
TOLERANCE: Final = 0.1
"""Share of full deflection by which a report may exceed what was sent: the chair rounds and filters."""
PERSISTENCE: Final = 0.2
"""Seconds that the difference must last: it is reported once, and the bridge then gives up."""


class OverrideCheck:
    """Compares the values that were sent with those that the chair reports. Deflections are forward and turn."""

    def __init__(self) -> None:
        self._sent: deque[tuple[float, float, float]] = deque(maxlen=1000)
        self._wrong_since: float | None = None

    def sent(self, forward: float, turn: float, now: float) -> None:
        """Note an override that was sent at a time, in seconds."""
        self._sent.append((now, forward, turn))

    def is_explained(self, forward: float, turn: float, now: float) -> bool:
        """Return whether a report fits what was sent, or does not yet differ for `PERSISTENCE`."""
        # The newest older one was in force when the memory begins.
        while len(self._sent) > 1 and self._sent[1][0] <= now - MEMORY:
            self._sent.popleft()
        if all(self._fits(axis, value) for axis, value in ((1, forward), (2, turn))):
            self._wrong_since = None
            return True
        if self._wrong_since is None:
            self._wrong_since = now
        return now - self._wrong_since < PERSISTENCE

    def _fits(self, axis: int, value: float) -> bool:
        values = [0.0, *(sent[axis] for sent in self._sent)]
        return min(values) - TOLERANCE <= value <= max(values) + TOLERANCE
