"""Sends the motor power to the driver: 20 times a second, and at once when it changes.

It has a thread of its own, so that neither a slow network nor a slow simulator delays the zero after 0.3 s of silence.
If this whole process dies, the controller's own watchdog stops the motors.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from intellwheels_agents.bridge.hardware_driver import Driver
from intellwheels_agents.bridge.motor_deadman import MotorDeadman
from intellwheels_agents.bridge.timeouts import POWER_PERIOD, POWER_POLL


class MotorWriter:
    """Writes motor powers to a driver."""

    def __init__(self, motors: MotorDeadman, driver: Driver, lockstep: Callable[[], bool | None]) -> None:
        """Create a writer.

        Args:
            motors: Gives the power.
            driver: Receives it.
            lockstep: Whether the simulation is in lockstep. The laboratory then reads the power itself, tick by tick.
        """
        self._motors = motors
        self._driver = driver
        self._lockstep = lockstep
        self._last = (0.0, 0.0)
        self._written = float("-inf")

    def run(self, stop: threading.Event) -> None:
        """Write until `stop` is set, and a zero at the end."""
        while not stop.is_set():
            self.step(time.monotonic())
            stop.wait(POWER_POLL)
        self._driver.write(0.0, 0.0)

    def step(self, now: float) -> None:
        """Write the power if it has changed or is due again; `now` is in seconds."""
        if self._lockstep():
            return
        power = self._motors.output(now)
        if power != self._last or now - self._written >= POWER_PERIOD:
            self._last, self._written = power, now
            self._driver.write(*power)
