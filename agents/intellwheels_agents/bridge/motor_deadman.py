"""What the motors are to give: the newest power that arrived, and nothing after 0.3 s of silence. Pure but for a lock.

The network's thread says what the simulation wants; the hardware's thread asks what to give.
"""

from __future__ import annotations

import threading
from typing import Final

from intellwheels_agents.bridge.line_faults import ROUNDING, Faults, FaultyLine
from intellwheels_schemas.messages import PowerInForce

SILENCE: Final = 0.3
"""Seconds without a power after which the motors get none: the contract's, for role `body`."""
_NONE: Final = (0.0, 0.0)


class MotorDeadman:
    """The powers on their way to the motors."""

    def __init__(self, faults: Faults | None = None, name: str = "down") -> None:
        self._line: FaultyLine[PowerInForce] = FaultyLine(faults or Faults(), name)
        self._lock = threading.Lock()
        self._newest: PowerInForce | None = None
        self._at = 0.0

    @property
    def lost(self) -> int:
        """Powers that the line lost."""
        return self._line.lost

    def obey(self, power: PowerInForce, now: float) -> None:
        """Take what the simulation wants at a time, in seconds."""
        with self._lock:
            self._line.send(power, now)

    def renew(self) -> None:
        """Forget everything: a new run."""
        with self._lock:
            self._line.renew()
            self._newest = None

    def output(self, now: float) -> tuple[float, float]:
        """Return the powers of the left and right motor at a time, both in [-1, 1]."""
        with self._lock:
            for due, power in self._line.arrived(now):
                newest = self._newest
                # What was overtaken is not obeyed; a run that is another is a newer one, as `renew` was called.
                if newest is None or newest.run != power.run or power.tick >= newest.tick:
                    self._newest, self._at = power, due
            if self._newest is None or now - self._at > SILENCE + ROUNDING:
                return _NONE
            return self._newest.left_motor, self._newest.right_motor
