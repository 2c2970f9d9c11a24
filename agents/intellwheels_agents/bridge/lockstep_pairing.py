"""Two worlds in lockstep, tick by tick: what each must wait for in the other.

Tick t of the laboratory pairs with tick t of the simulation, and their runs pair in order. The laboratory's Measures t
give the simulation's Pose t. The simulation's Power t - 1 (zero at first) gives the laboratory's Actions t. Runs
are counted from the join. A run that is reset before its first tick exists in one world only and would shift the pairs.

    laboratory   Measures t ----------------> Actions t -> Measures t+1
                          |                    ^
    simulation   Measures t -> Pose t -> Power t-1 is here already; Power t -> ...

A side never waits for a message that the other side cannot send. It does not wait for a side that is a run behind
either: that run is over, and the reset is on its way.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Final

MAX_WAIT: Final = 600.0
"""Longest wait in seconds. The worlds themselves wait for an answer for ten seconds or their --deadline."""
_SLICE: Final = 0.1


class Side:
    """The progress of one world.

    Attributes:
        number: Runs so far.
        tick: The newest tick: of measures in the laboratory, of powers in the simulation.
    """

    def __init__(self) -> None:
        self.number = 0
        self.tick = -1
        self._run = ""

    def begin_run(self, run: str) -> None:
        """Note the current run. Nothing changes if it is known already."""
        if run != self._run:
            self._run = run
            self.number += 1
            self.tick = -1

    def is_in(self, run: str) -> bool:
        """Return whether a run is the current one."""
        return run == self._run


class LockstepPairing:
    """The two worlds of a bridge."""

    def __init__(self, stop: threading.Event) -> None:
        """Create the pairing; `stop` ends every wait."""
        self._stop = stop
        self._changed = threading.Condition()
        self._laboratory = Side()
        self._simulation = Side()

    @property
    def simulation_run(self) -> int:
        """The number of the simulation's run."""
        return self._simulation.number

    def laboratory_run_began(self, run: str) -> int:
        """Note that the laboratory is in a run; return the run's number."""
        with self._changed:
            self._laboratory.begin_run(run)
            return self._laboratory.number

    def laboratory_measured(self, run: str, tick: int) -> None:
        """Note the arrival of the laboratory's measures of a tick."""
        with self._changed:
            self._laboratory.begin_run(run)
            self._laboratory.tick = tick
            self._changed.notify_all()

    def simulation_run_began(self, run: str) -> None:
        """Note that the simulation is in a run."""
        with self._changed:
            self._simulation.begin_run(run)
            self._changed.notify_all()

    def simulation_powered(self, run: str, tick: int) -> None:
        """Note the arrival of the simulation's power of a tick."""
        with self._changed:
            if self._simulation.is_in(run):
                self._simulation.tick = max(self._simulation.tick, tick)
                self._changed.notify_all()

    def await_measures(self, tick: int) -> bool:
        """Wait in the simulation's thread for the laboratory's measures of a tick; return whether they have come."""
        return self._await(self._simulation, self._laboratory, tick)

    def await_power(self, tick: int) -> bool:
        """Wait in the laboratory's thread for the simulation's power of a tick; return whether it has come."""
        return self._await(self._laboratory, self._simulation, tick)

    def _await(self, own: Side, other: Side, tick: int) -> bool:
        number = own.number
        return (
            self._wait(lambda: other.number > number or (other.number == number and other.tick >= tick))
            and other.number == number
        )

    def _wait(self, is_done: Callable[[], bool]) -> bool:
        deadline = time.monotonic() + MAX_WAIT
        with self._changed:
            while not is_done():
                if self._stop.is_set() or time.monotonic() > deadline:
                    return False
                self._changed.wait(_SLICE)
        return True
