"""The motion of a chair without encoders, from the joystick that it obeys: dead reckoning. Pure.

With F and T the deflection, s the share of the top speed that the user has chosen, V the top speed of a wheel:

    wanted speeds   left = s V (F - T),  right = s V (F + T),  both divided by max(1, |F - T|, |F + T|)

The wheels follow with the chair's `AccelerationCurve`, as in the simulation. Slopes, loads and caster wheels make a
real chair differ, so the error grows by some per cent of the way.
"""

from __future__ import annotations

import math
from typing import Final

from intellwheels_agents.user_input import mixed
from intellwheels_agents.wheel_motors import STILL, Motors, Wheels
from intellwheels_schemas.messages import Robot

CYCLE: Final = 0.01
"""Seconds of one step: the period of R-Net's joystick."""
LONGEST: Final = 0.3
"""Seconds without a joystick after which the chair counts as standing still."""


class StickMotion:
    """The wheels of a chair as its joystick moves them.

    Attributes:
        speed_limit: Share of the top speed that the user has chosen, in [0, 1].
    """

    def __init__(self, chair: Robot) -> None:
        """Start at rest; the chair gives top speed, acceleration and the counts of a turn."""
        self.speed_limit = 1.0
        self._top = chair.top_speed
        self._motors = Motors.of(chair, CYCLE)
        self._per_metre = chair.encoder_ticks / (math.pi * chair.wheel_diameter)
        self._speeds = STILL
        self._left = self._right = 0.0
        self._wanted = STILL
        self._at: float | None = None

    def obey(self, forward: float, turn: float) -> None:
        """Set the deflection from now on."""
        left, right = mixed(forward, turn)
        top = self._top * self.speed_limit
        self._wanted = Wheels(left * top, right * top)

    def advance(self, now: float) -> tuple[int, int]:
        """Return the counts that encoders on the wheels would show at a time in seconds."""
        if self._at is None or now - self._at > LONGEST:
            self._speeds, self._at = STILL, now
        while now - self._at >= CYCLE:
            self._speeds, travel = self._motors.cycle(self._speeds, self._wanted)
            self._left += travel.left
            self._right += travel.right
            self._at += CYCLE
        return round(self._left * self._per_metre), round(self._right * self._per_metre)
