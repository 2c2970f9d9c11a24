"""The chair's own joystick as a person's hand: what the electronics say of it goes to `user/<agent>`."""

from __future__ import annotations

import threading

from intellwheels_agents.bridge.hardware_driver import Reading
from intellwheels_agents.joystick.wish import NOTHING, Wish

REST = 0.02
"""Of full deflection: a stick at rest trembles less."""
SILENCE = 0.3
"""Seconds after which a stick that is not heard of wants nothing."""


class StickSource:
    """A `joystick.wish.Source` that is told what the stick does."""

    def __init__(self, stop: threading.Event) -> None:
        self._stop = stop
        self._wish: Wish = NOTHING
        self._at = float("-inf")

    def hear(self, reading: Reading) -> None:
        """Take a reading."""
        if reading.forward is None or reading.turn is None:
            return
        rests = max(abs(reading.forward), abs(reading.turn)) < REST
        self._wish = NOTHING if rests else Wish(forward=reading.forward, turn=reading.turn)
        self._at = reading.arrived

    def wait(self, seconds: float) -> None:
        """Return after so long, or when all ends."""
        self._stop.wait(seconds)

    def wish(self, now: float, time: float | None) -> Wish | None:  # noqa: ARG002 - as `Source` has it
        """Return what the stick wants, or None at the end."""
        if self._stop.is_set():
            return None
        return self._wish if now - self._at <= SILENCE else NOTHING
