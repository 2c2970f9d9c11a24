"""What keeps the motors told: the power in force, 20 times a second, and at once when it changes.

A thread of its own, so that neither a slow network nor a slow simulator keeps the zero of the 0.3 s from the motors.
The controller's own watchdog is for the death of this process.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Final

from intellwheels_agents.bridge.hardware_driver import Driver
from intellwheels_agents.bridge.motor_deadman import MotorDeadman

EVERY: Final = 0.05
LOOK: Final = 0.01
"""Seconds between two looks; a new power waits so long at most."""


class MotorWriter:
    """Writes motor powers to a driver."""

    def __init__(self, motors: MotorDeadman, driver: Driver, lockstep: Callable[[], bool | None]) -> None:
        """Make it.

        Args:
            motors: Say what to give.
            driver: Takes it.
            lockstep: Whether the simulation is in lockstep: then the laboratory itself asks the motors, tick by tick.
        """
        self._motors = motors
        self._driver = driver
        self._lockstep = lockstep
        self._last = (0.0, 0.0)
        self._at = float("-inf")

    def run(self, stop: threading.Event) -> None:
        """Write until `stop`, and then nothing but a zero."""
        while not stop.is_set():
            self.turn(time.monotonic())
            stop.wait(LOOK)
        self._driver.write(0.0, 0.0)

    def turn(self, now: float) -> None:
        """Write, if it is time."""
        if self._lockstep():
            return
        power = self._motors.output(now)
        if power != self._last or now - self._at >= EVERY:
            self._last, self._at = power, now
            self._driver.write(*power)
