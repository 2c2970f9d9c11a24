"""A line with delay, jitter and loss, for experiments. The same seed gives the same faults. Pure."""

from __future__ import annotations

import heapq
import random
from dataclasses import dataclass
from typing import Final, Generic, TypeVar

_T = TypeVar("_T")
ROUNDING: Final = 1e-9
"""Seconds of tolerance for a time that is a sum of periods."""


@dataclass(frozen=True, slots=True)
class Faults:
    """The faults of a line.

    Attributes:
        delay: Seconds.
        jitter: Largest additional delay in seconds, uniformly distributed; messages may overtake each other.
        loss: Share of the messages that never arrive, in [0, 1].
        seed: Determines all of it.
    """

    delay: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0
    seed: str = "1"


class FaultyLine(Generic[_T]):
    """A line with faults. The caller passes the time.

    Attributes:
        lost: Number of messages that never arrive.
    """

    def __init__(self, faults: Faults, name: str) -> None:
        """Create a line. `name` separates its random numbers from those of other lines with the same seed."""
        self.lost = 0
        self._faults = faults
        self._name = name
        self.reset()

    def reset(self) -> None:
        """Drop all messages in flight and restart the random numbers."""
        self._random = random.Random(f"{self._faults.seed}/{self._name}")  # noqa: S311 - faults, not secrets
        self._sent = 0
        self._in_flight: list[tuple[float, int, _T]] = []

    def send(self, message: _T, at: float) -> None:
        """Send a message at a time, in seconds."""
        # Both are drawn every time, so that one message's fate does not depend on the options of the other fault.
        jitter, luck = self._random.random(), self._random.random()
        self._sent += 1
        if luck < self._faults.loss:
            self.lost += 1
            return
        due = at + self._faults.delay + self._faults.jitter * jitter
        heapq.heappush(self._in_flight, (due, self._sent, message))

    def receive(self, until: float) -> list[tuple[float, _T]]:
        """Return and remove the messages that have arrived by a time, each with its time of arrival."""
        found = []
        while self._in_flight and self._in_flight[0][0] <= until + ROUNDING:
            due, _, message = heapq.heappop(self._in_flight)
            found.append((due, message))
        return found
