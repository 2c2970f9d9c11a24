"""Drives as its user wants, without looking.

    speed    share of the motor power at full forward (default 1)
    turn     share of the motor power at full turn (default 1)
    words    deflection for the words forward, back, left and right; stop is always 0 (default 0.5)

The user is whoever writes the Zenoh key `user/<agent>`: `iw-joystick`, the viewer, or a program of your own. If the
user is silent for 0.3 s, the simulator clears the input. The motors then lose power, and the chair coasts to a stop.
This mind ignores obstacles; `aided` stops for them.
"""

from __future__ import annotations

from intellwheels_agents.mind import Context
from intellwheels_agents.user_input import mixed, wanted
from intellwheels_agents.user_input import takes_drive as equip
from intellwheels_schemas.messages import Actions, Measures

__all__ = ["Mind", "equip"]


class Mind:
    """Gives the powers that its user wants."""

    def __init__(self, context: Context) -> None:
        options = context.options
        self._speed = options.number("speed", 1.0, 0.0, 1.0)
        self._turn = options.number("turn", 1.0, 0.0, 1.0)
        self._words = options.number("words", 0.5, 0.0, 1.0)

    def decide(self, measures: Measures) -> Actions:
        """Return the powers for the present user input."""
        forward, turn = wanted(measures.user_input, self._words)
        left, right = mixed(forward * self._speed, turn * self._turn)
        return Actions(left_motor=left, right_motor=right, mode="manual")
