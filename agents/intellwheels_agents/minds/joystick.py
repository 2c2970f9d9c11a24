"""Drives as its user wants, and does not look.

    speed    share of the power that full forward gives, in [0, 1] (default 1)
    turn     share of the power that full turn gives, in [0, 1] (default 1)
    words    share of full that a word alone asks for: forward, back, left, right, stop (default 0.5)

The user is whoever writes `user/<agent>`: `iw-joystick`, a page, a voice recogniser. A user who is silent for 0.3 s
wants nothing; the simulator sees to that. What stands in the way does not matter to it: `aided` looks.
"""

from __future__ import annotations

import msgspec

from intellwheels_agents.mind import Context
from intellwheels_agents.options import Options
from intellwheels_agents.user_input import mixed, wanted
from intellwheels_schemas.messages import Actions, Measures, Robot


def equip(robot: Robot, options: Options) -> Robot:  # noqa: ARG001 - as `Equip` has it
    """Return the robot with user input declared."""
    return msgspec.structs.replace(robot, user_input=("drive", "words"))


class Mind:
    """Gives the powers that its user wants."""

    def __init__(self, context: Context) -> None:
        options = context.options
        self._speed = options.number("speed", 1.0, 0.0, 1.0)
        self._turn = options.number("turn", 1.0, 0.0, 1.0)
        self._words = options.number("words", 0.5, 0.0, 1.0)

    def decide(self, measures: Measures) -> Actions:
        """Return the powers for what is wanted now."""
        forward, turn = wanted(measures.user_input, self._words)
        left, right = mixed(forward * self._speed, turn * self._turn)
        return Actions(left_motor=left, right_motor=right, mode="manual")
