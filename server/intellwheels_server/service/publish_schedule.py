"""When state and clock go out. Pure: time is passed in.

Every tick up to 60 a second of wall time, the last before a stop always, and twice a second while nothing moves.
Who listens does not matter.
"""

from __future__ import annotations

from typing import Final

FASTEST: Final = 1.0 / 60.0
"""Seconds between two publications at least."""
IDLE: Final = 0.5
"""Seconds between two publications while nothing moves."""


class Cadence:
    """Decides of each moment whether to publish."""

    def __init__(self) -> None:
        self._last = float("-inf")
        self._news = True

    def note(self) -> None:
        """Note that there is something new."""
        self._news = True

    def due(self) -> float:
        """Return when to publish next if nothing else happens."""
        return self._last + (FASTEST if self._news else IDLE)

    def ready(self, now: float) -> bool:
        """Return whether to publish now; if so, it counts as done."""
        if now < self._last + (FASTEST if self._news else IDLE):
            return False
        self.done(now)
        return True

    def done(self, now: float) -> None:
        """Note that everything was published now, asked for or not."""
        self._last = now
        self._news = False

    @property
    def news(self) -> bool:
        """Whether something has not been published yet."""
        return self._news
