"""Two lockstep worlds tick by tick: what the one must wait for in the other.

Tick t of the laboratory pairs with tick t of the simulation, and their runs pair in order. The laboratory's Measures t
make the simulation's Pose t; the simulation's Power t - 1, nothing at first, makes the laboratory's Actions t. A run
counts from joining on: one that is reset before its first tick is seen in one world only would part them for good.

    lab    Measures t ----------------> Actions t -> Measures t+1
                    |                    ^
    here   Measures t -> Pose t -> Power t-1 is here already; Power t -> ...

So neither waits for what the other cannot give. Whoever is a run behind its partner is not waited with: that run is
over, as its reset is on its way.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Final

PATIENCE: Final = 600.0
"""Seconds a side waits at most. Their own worlds wait ten for an answer, or as long as they are told to."""
_SLICE: Final = 0.1


class Side:
    """How far a world is.

    Attributes:
        number: Runs so far.
        tick: The newest tick: of measures there, of powers here.
    """

    def __init__(self) -> None:
        self.number = 0
        self.tick = -1
        self._run = ""

    def enter(self, run: str) -> None:
        """Note that a run is on."""
        if run != self._run:
            self._run = run
            self.number += 1
            self.tick = -1

    def is_in(self, run: str) -> bool:
        """Return whether that run is on."""
        return run == self._run


class LockstepPairing:
    """The two sides."""

    def __init__(self, stop: threading.Event) -> None:
        """Make it; `stop` ends every wait."""
        self._stop = stop
        self._news = threading.Condition()
        self._lab = Side()
        self._here = Side()

    @property
    def here(self) -> int:
        """The number of the simulation's run."""
        return self._here.number

    def lab_entered(self, run: str) -> int:
        """Note that the laboratory is in a run; return the run's number."""
        with self._news:
            self._lab.enter(run)
            return self._lab.number

    def lab_measured(self, run: str, tick: int) -> None:
        """Note that the laboratory's measures of a tick came."""
        with self._news:
            self._lab.enter(run)
            self._lab.tick = tick
            self._news.notify_all()

    def here_entered(self, run: str) -> None:
        """Note that the simulation is in a run."""
        with self._news:
            self._here.enter(run)
            self._news.notify_all()

    def here_powered(self, run: str, tick: int) -> None:
        """Note that the simulation's power of a tick came."""
        with self._news:
            if self._here.is_in(run):
                self._here.tick = max(self._here.tick, tick)
                self._news.notify_all()

    def await_measures(self, tick: int) -> bool:
        """Wait, in the simulation's thread, for the laboratory's measures of a tick; return whether they are here."""
        return self._await(self._here, self._lab, tick)

    def await_power(self, tick: int) -> bool:
        """Wait, in the laboratory's thread, for the simulation's power of a tick; return whether it is here."""
        return self._await(self._lab, self._here, tick)

    def _await(self, mine: Side, other: Side, tick: int) -> bool:
        number = mine.number
        return (
            self._wait(lambda: other.number > number or (other.number == number and other.tick >= tick))
            and other.number == number
        )

    def _wait(self, found: Callable[[], bool]) -> bool:
        until = time.monotonic() + PATIENCE
        with self._news:
            while not found():
                if self._stop.is_set() or time.monotonic() > until:
                    return False
                self._news.wait(_SLICE)
        return True
