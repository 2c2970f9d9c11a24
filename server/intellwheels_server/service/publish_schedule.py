"""When state and clock are published. Pure: time is passed in.

At every tick, but at most 60 times a second of wall time; always after the last change; twice a second while nothing
changes. While time goes on and no body moves, only the clock changes, so the state goes out twice a second. The number
of subscribers does not matter.
"""

from __future__ import annotations

from typing import Final

MIN_INTERVAL: Final = 1.0 / 60.0
"""Shortest time between two publications, s."""
IDLE_INTERVAL: Final = 0.5
"""Time between two publications while nothing changes, s."""


class PublishSchedule:
    """Decides when to publish."""

    def __init__(self) -> None:
        self._last = float("-inf")
        self._changed = True
        self._shown: object = None
        self._shown_at = float("-inf")

    def mark_changed(self) -> None:
        """Note that something has changed."""
        self._changed = True

    def mark_published(self, now: float) -> None:
        """Note that everything is published now, whether or not it was due."""
        self._last = now
        self._changed = False

    def due(self) -> float:
        """Return when to publish next if nothing else happens."""
        return self._last + (MIN_INTERVAL if self._changed else IDLE_INTERVAL)

    def take_due(self, now: float) -> bool:
        """Return whether to publish now; if so, it counts as published."""
        if now < self.due():
            return False
        self.mark_published(now)
        return True

    def take_state(self, shown: object, now: float) -> bool:
        """Return whether to publish a state now; if so, it counts as published.

        Args:
            shown: All that the state shows, except the tick: an unchanged state goes out twice a second.
            now: The time, s.
        """
        # A tick may come a little early.
        if shown == self._shown and now - self._shown_at < IDLE_INTERVAL - MIN_INTERVAL:
            return False
        self.mark_state(shown, now)
        return True

    def mark_state(self, shown: object, now: float) -> None:
        """Note that a state is published now, whether or not it was due."""
        self._shown, self._shown_at = shown, now
