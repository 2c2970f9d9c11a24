"""The chair's own joystick as a source of user input: its deflection goes to `user/<agent>`."""

from __future__ import annotations

import threading
from typing import Final

from intellwheels_agents.bridge.hardware_driver import Reading
from intellwheels_agents.bridge.timeouts import STICK_TIMEOUT
from intellwheels_agents.joystick.input_state import NEUTRAL, InputState

DEAD_ZONE: Final = 0.02
"""Share of full deflection that still counts as released: a stick at rest trembles less than this."""


class ChairJoystick:
    """An `input_state.Source` whose state comes from hardware readings."""

    def __init__(self, stop: threading.Event) -> None:
        self._stop = stop
        self._state: InputState = NEUTRAL
        self._received = float("-inf")

    def on_reading(self, reading: Reading) -> None:
        """Update the stick from a reading; one without a joystick changes nothing."""
        if reading.forward is None or reading.turn is None:
            return
        released = max(abs(reading.forward), abs(reading.turn)) < DEAD_ZONE
        self._state = NEUTRAL if released else InputState(forward=reading.forward, turn=reading.turn)
        self._received = reading.received

    def wait(self, seconds: float) -> None:
        """Wait, or return early when the process stops."""
        self._stop.wait(seconds)

    def state(self, now: float, time: float | None) -> InputState | None:  # noqa: ARG002 - as `Source` has it
        """Return the stick's state, neutral after `STICK_TIMEOUT`, or None when the process stops."""
        if self._stop.is_set():
            return None
        return self._state if now - self._received <= STICK_TIMEOUT else NEUTRAL
