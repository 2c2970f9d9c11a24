"""A chair that obeys a joystick, as the stand-ins of this folder play it: its motors and what its wheels turn. Pure."""

from __future__ import annotations

from typing import Final

from intellwheels_agents.bridge.timeouts import CONTROLLER_WATCHDOG
from intellwheels_agents.user_input import mixed

MOTOR_LAG: Final = 0.1
"""Seconds in which a wheel comes within 1/e of the commanded speed."""


class JoystickChair:
    """The motors of a chair, commanded by the deflection of a joystick.

    Attributes:
        clock: Seconds since the start.
        stick: Forward and turn in force, in [-1, 1], turn positive to the left.
        travel: Metres that the left and right wheel have rolled.
        messages: Lines for people and scripts, not yet printed.
    """

    def __init__(self, top_speed: float, *, watchdog: float = CONTROLLER_WATCHDOG) -> None:
        """Start at rest; the motors stop `watchdog` seconds after the last command."""
        self.clock = 0.0
        self.stick = (0.0, 0.0)
        self.travel = [0.0, 0.0]
        self.messages: list[str] = []
        self._top_speed = top_speed
        self._watchdog = watchdog
        self._commanded = float("-inf")
        self._speed = [0.0, 0.0]

    def command(self, forward: float, turn: float) -> None:
        """Obey a deflection."""
        if self._commanded < 0.0:
            self.messages.append(f"powered ms={round(1000.0 * self.clock)}")
        self._commanded = self.clock
        self._set((forward, turn), -1)

    def step(self, seconds: float) -> None:
        """Advance by some seconds."""
        self.clock += seconds
        silence = self.clock - self._commanded
        if silence >= self._watchdog and self.stick != (0.0, 0.0):
            self._set((0.0, 0.0), round(1000.0 * silence))
        share = min(1.0, seconds / MOTOR_LAG)
        for wheel, power in enumerate(mixed(*self.stick)):
            self._speed[wheel] += share * (power * self._top_speed - self._speed[wheel])
            self.travel[wheel] += self._speed[wheel] * seconds

    def take_messages(self) -> list[str]:
        """Return the lines since the last call."""
        messages, self.messages = self.messages, []
        return messages

    def _set(self, stick: tuple[float, float], silence: int) -> None:
        if stick == (0.0, 0.0) and self.stick != (0.0, 0.0):
            self.messages.append(f"stopped ms={round(1000.0 * self.clock)} silence={silence}")
        elif stick != (0.0, 0.0) and self.stick == (0.0, 0.0):
            self.messages.append(f"moving ms={round(1000.0 * self.clock)}")
        self.stick = stick
