"""A line that is late, uneven and loses things, for experiments: what it does follows from its seed. Pure."""

from __future__ import annotations

import heapq
import random
from dataclasses import dataclass
from typing import Final, Generic, TypeVar

_T = TypeVar("_T")
ROUNDING: Final = 1e-9
"""Seconds by which a time that is a sum of periods may be off."""


@dataclass(frozen=True, slots=True)
class Faults:
    """What is wrong with a line.

    Attributes:
        delay: Seconds.
        jitter: Further seconds at most, evenly spread; what is sent later may arrive sooner.
        loss: Share that never arrives.
        seed: What happens follows from it.
    """

    delay: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0
    seed: str = "1"


class FaultyLine(Generic[_T]):
    """A line with faults. The caller says what time it is.

    Attributes:
        lost: Things that will never arrive.
    """

    def __init__(self, faults: Faults, name: str) -> None:
        """Make a line; `name` tells it from others of the same seed."""
        self.lost = 0
        self._faults = faults
        self._name = name
        self.renew()

    def renew(self) -> None:
        """Forget what is on its way, and begin the faults anew."""
        self._random = random.Random(f"{self._faults.seed}/{self._name}")  # noqa: S311 - faults, not secrets
        self._sent = 0
        self._way: list[tuple[float, int, _T]] = []

    def send(self, thing: _T, at: float) -> None:
        """Send a thing at a time, in seconds."""
        # Both are drawn for each, so that what one thing meets does not depend on the options.
        late, luck = self._random.random(), self._random.random()
        self._sent += 1
        if luck < self._faults.loss:
            self.lost += 1
            return
        heapq.heappush(self._way, (at + self._faults.delay + self._faults.jitter * late, self._sent, thing))

    def arrived(self, by: float) -> list[tuple[float, _T]]:
        """Return what has arrived by a time, with when, and forget it."""
        found = []
        while self._way and self._way[0][0] <= by + ROUNDING:
            due, _, thing = heapq.heappop(self._way)
            found.append((due, thing))
        return found
