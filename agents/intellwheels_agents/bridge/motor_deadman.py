"""The current motor power: the newest that arrived, or zero after 0.3 s of silence or while the gate is closed.

The network's thread sets the powers that the simulation asks for; the hardware's thread reads the one in force.
"""

from __future__ import annotations

import threading
from typing import Final

from intellwheels_agents.bridge.line_faults import ROUNDING, Faults, FaultyLine
from intellwheels_agents.bridge.resume_gate import ResumeGate
from intellwheels_agents.bridge.timeouts import POWER_TIMEOUT
from intellwheels_schemas.messages import PowerInForce

_ZERO: Final = (0.0, 0.0)


class MotorDeadman:
    """The powers on their way to the motors."""

    def __init__(self, faults: Faults | None = None, name: str = "down", gate: ResumeGate | None = None) -> None:
        self._line: FaultyLine[PowerInForce] = FaultyLine(faults or Faults(), name)
        self._gate = gate
        self._lock = threading.Lock()
        self._newest: PowerInForce | None = None
        self._received = 0.0

    @property
    def lost(self) -> int:
        """Number of powers lost on the line."""
        return self._line.lost

    def set_power(self, power: PowerInForce, now: float) -> None:
        """Set the power that the simulation asks for at a time, in seconds."""
        if self._gate is not None:
            self._gate.power_received()
        with self._lock:
            self._line.send(power, now)

    def reset(self) -> None:
        """Forget everything, because a new run starts."""
        with self._lock:
            self._line.reset()
            self._newest = None

    def output(self, now: float) -> tuple[float, float]:
        """Return the powers of the left and right motor at a time in seconds, both in [-1, 1]."""
        if self._gate is not None and not self._gate.is_open:
            return _ZERO
        with self._lock:
            for due, power in self._line.receive(now):
                newest = self._newest
                # An overtaken power is dropped. Another run is always a newer one, because `reset` comes between.
                if newest is None or newest.run != power.run or power.tick >= newest.tick:
                    self._newest, self._received = power, due
            if self._newest is None or now - self._received > POWER_TIMEOUT + ROUNDING:
                return _ZERO
            return self._newest.left_motor, self._newest.right_motor
