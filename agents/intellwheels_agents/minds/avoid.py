"""Wanders about and avoids the obstacles that its proximity sensors see.

    speed    speed with nothing near, m/s (default 0.5)
    clear    distance ahead at which it begins to slow down, m (default 1.5)
    stop     distance ahead at which it turns in place, m (default 0.5)

It turns to the side with more clearance. Once it turns in place it keeps turning to that side until the way ahead is
free; otherwise it would swing back and forth in a corner forever.
"""

from __future__ import annotations

from intellwheels_agents.differential_drive import powers
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError
from intellwheels_agents.path_follower import TURN_RATE
from intellwheels_agents.range_scan import RangeScan, outline
from intellwheels_schemas.messages import Actions, Measures

SWING = 0.12
"""Clearance in front of a front corner, and beside the back, below which it does not turn, m; from twice that on it
turns at the full rate."""
CORNER = 0.3
"""Clearance in front of a front corner at which it turns in place, m."""


class Mind:
    """Decides from the readings of the present tick."""

    def __init__(self, context: Context) -> None:
        options = context.options
        self._robot = context.robot
        self._speed = options.number("speed", 0.5, 0.0, 5.0)
        self._clear = options.number("clear", 1.5, 0.1, 20.0)
        self._stop = options.number("stop", 0.5, 0.05, 20.0)
        if self._stop >= self._clear:
            raise OptionError(f"option stop: expected less than clear ({self._clear:g}), got {self._stop:g}")
        self._scan = RangeScan(context.robot)
        self._turning = 0.0
        # A long back swings out farther.
        self._tail = SWING * max(1.0, outline(context.robot).back / 0.5)

    def decide(self, measures: Measures) -> Actions:
        """Return the powers for the present readings."""
        scan = self._scan
        scan.update(measures.sensors)
        ahead = scan.gap
        blocked = (
            min(scan.front_left, scan.front_right) < CORNER
            or ahead < self._stop * (1.5 if self._turning else 1.0)
            or measures.collision
        )
        if blocked:
            return self._turn_in_place()
        self._turning = 0.0
        share = min(1.0, (ahead - self._stop) / (self._clear - self._stop))
        side = 1.0 if scan.left >= scan.right else -1.0
        # To the sides, obstacles count from half of `clear` on.
        bend = max(1.0 - share, 1.0 - min(scan.left, scan.right) / (self._clear / 2.0), 0.0)
        rate = side * bend * self._turn_share(side) * TURN_RATE / 2.0
        return self._actions(self._speed * max(share, 0.15), rate)

    def _turn_in_place(self) -> Actions:
        scan = self._scan
        side = self._turning or (1.0 if scan.left >= scan.right else -1.0)
        # It keeps turning to the same side, unless it is blocked there and not on the other side.
        if self._turn_share(side) == 0.0 and self._turn_share(-side) > 0.0:
            side = -side
        self._turning = side
        share = self._turn_share(side)
        if share > 0.0:
            return self._actions(0.0, side * share * TURN_RATE)
        if min(scan.back, scan.back_left, scan.back_right) > SWING:
            return self._actions(-0.2 * self._speed, 0.0)
        # Blocked on all sides; a slow turn may still free it.
        return self._actions(0.0, side * 0.2 * TURN_RATE)

    def _turn_share(self, side: float) -> float:
        """Return the share of the turn rate that the clearances allow, in [0, 1].

        A front corner swings to the side of the turn, the back to the other.
        """
        scan = self._scan
        front, back = (scan.front_left, scan.back_right) if side > 0.0 else (scan.front_right, scan.back_left)
        spare = min(front - SWING, (back - self._tail) * SWING / self._tail)
        return min(1.0, max(0.0, spare / SWING))

    def _actions(self, speed: float, turn_rate: float) -> Actions:
        left, right = powers(self._robot, speed, turn_rate)
        return Actions(left_motor=left, right_motor=right, mode="autonomous")
