"""Wanders and keeps clear of what its proximity sensors see.

    speed    metres a second with nothing near (default 0.5)
    clear    metres ahead from which it slows down (default 1.5)
    stop     metres ahead at which it turns in place (default 0.5)

It bends to the side with more room; once it turns in place it keeps to that side until the way
ahead is free, or two walls would send it to and fro for ever.
"""

from __future__ import annotations

from intellwheels_agents.chair import powers
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError
from intellwheels_agents.surroundings import Surroundings
from intellwheels_schemas.messages import Actions, Measures

TURN_RATE = 0.8
"""Radians a second, turning in place: a quarter turn in two seconds."""


class Mind:
    """Reacts to the readings of the tick."""

    def __init__(self, context: Context) -> None:
        options = context.options
        self._robot = context.robot
        self._speed = options.number("speed", 0.5, 0.0, 5.0)
        self._clear = options.number("clear", 1.5, 0.1, 20.0)
        self._stop = options.number("stop", 0.5, 0.05, 20.0)
        if self._stop >= self._clear:
            raise OptionError(f"option stop: expected less than clear ({self._clear:g}), got {self._stop:g}")
        self._around = Surroundings(context.robot)
        self._turning = 0.0

    def decide(self, measures: Measures) -> Actions:
        """Return the powers for what is seen now."""
        around = self._around
        around.update(measures.sensors)
        side = 1.0 if around.left >= around.right else -1.0
        ahead = around.gap
        if self._turning and ahead < self._stop * 1.5:
            return self._actions(0.0, self._turning * TURN_RATE)
        self._turning = 0.0
        if ahead < self._stop or measures.collision:
            self._turning = side
            return self._actions(0.0, side * TURN_RATE)
        share = min(1.0, (ahead - self._stop) / (self._clear - self._stop))
        near = min(around.left, around.right)
        # Beside, half of `clear` is near enough to bend away.
        bend = max(1.0 - share, 1.0 - near / (self._clear / 2.0), 0.0)
        return self._actions(self._speed * max(share, 0.15), side * bend * TURN_RATE / 2.0)

    def _actions(self, speed: float, turn_rate: float) -> Actions:
        left, right = powers(self._robot, speed, turn_rate)
        return Actions(left_motor=left, right_motor=right, mode="autonomous")
