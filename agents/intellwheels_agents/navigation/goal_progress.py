"""Whether a body comes nearer to its goal."""

from __future__ import annotations

from typing import Final

STEP: Final = 0.1
"""A smaller gain is no progress, m."""


class Progress:
    """Watches the cost to the goal.

    Attributes:
        stalled: Time without progress, s.
    """

    def __init__(self) -> None:
        self.stalled = 0.0
        self._best = float("inf")
        self._since = 0.0

    def reset(self, time: float) -> None:
        """Start again, with a new goal or plan."""
        self._best, self._since, self.stalled = float("inf"), time, 0.0

    def update(self, time: float, cost: float) -> None:
        """Take the cost to the goal at a time (s)."""
        if cost < self._best - STEP:
            self._best, self._since = cost, time
        self.stalled = time - self._since
