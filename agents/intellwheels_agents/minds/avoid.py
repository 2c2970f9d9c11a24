"""Wanders and keeps clear of what its proximity sensors see.

    speed    metres a second with nothing near (default 0.5)
    clear    metres ahead from which it slows down (default 1.5)
    stop     metres ahead at which it turns in place (default 0.5)

It bends to the side with more room; once it turns in place it keeps to that side until the way
ahead is free, or two walls would send it to and fro for ever.
"""

from __future__ import annotations

from intellwheels_agents.differential_drive import powers
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError
from intellwheels_agents.range_scan import RangeScan, outline
from intellwheels_schemas.messages import Actions, Measures

TURN_RATE = 0.8
"""Radians a second, turning in place: a quarter turn in two seconds."""
SWING = 0.12
"""Metres before a front corner and beside the back that a turn needs; with twice that it is free."""
CORNER = 0.3
"""Metres before a front corner at which it turns in place."""


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
        self._around = RangeScan(context.robot)
        self._turning = 0.0
        # A long back swings wider.
        self._tail = SWING * max(1.0, outline(context.robot).back / 0.5)

    def decide(self, measures: Measures) -> Actions:
        """Return the powers for what is seen now."""
        around = self._around
        around.update(measures.sensors)
        ahead = around.gap
        blocked = (
            min(around.front_left, around.front_right) < CORNER
            or ahead < self._stop * (1.5 if self._turning else 1.0)
            or measures.collision
        )
        if blocked:
            return self._turn_in_place()
        self._turning = 0.0
        share = min(1.0, (ahead - self._stop) / (self._clear - self._stop))
        side = 1.0 if around.left >= around.right else -1.0
        # Beside, half of `clear` is near enough to bend away.
        bend = max(1.0 - share, 1.0 - min(around.left, around.right) / (self._clear / 2.0), 0.0)
        rate = side * bend * self._swing(side) * TURN_RATE / 2.0
        return self._actions(self._speed * max(share, 0.15), rate)

    def _turn_in_place(self) -> Actions:
        around = self._around
        side = self._turning or (1.0 if around.left >= around.right else -1.0)
        # It keeps to its side unless there the way is barred and the other way is not.
        if self._swing(side) == 0.0 and self._swing(-side) > 0.0:
            side = -side
        self._turning = side
        swing = self._swing(side)
        if swing > 0.0:
            return self._actions(0.0, side * swing * TURN_RATE)
        if min(around.back, around.back_left, around.back_right) > SWING:
            return self._actions(-0.2 * self._speed, 0.0)
        # Caught on all sides; turning slowly may still free it.
        return self._actions(0.0, side * 0.2 * TURN_RATE)

    def _swing(self, side: float) -> float:
        """Return the share of the turn rate for which there is room: a front corner swings to, the back away."""
        around = self._around
        front, back = (around.front_left, around.back_right) if side > 0.0 else (around.front_right, around.back_left)
        room = min(front - SWING, (back - self._tail) * SWING / self._tail)
        return min(1.0, max(0.0, room / SWING))

    def _actions(self, speed: float, turn_rate: float) -> Actions:
        left, right = powers(self._robot, speed, turn_rate)
        return Actions(left_motor=left, right_motor=right, mode="autonomous")
