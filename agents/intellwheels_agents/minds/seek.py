"""Drives to a place and around the obstacles that its proximity sensors see.

    to       the goal (required)
    speed    speed with nothing near, m/s (default 0.6)
    clear    clearance that a direction must leave on both sides of the body to be chosen, m (default 0.06)
    within   distance from the place that counts as arrived, m (default 0.2)
    margin   clearance at which it stops, on all sides, m; half of it in a turn in place (default 0.05)
    ahead    seconds that it looks ahead; more if braking takes longer (default 1.0)

It locates itself by odometry alone, and obstacles by its proximity sensors alone. Of the directions in which the body
fits, it takes the one with the lowest cost. The obstacle check of `aided` then slows or stops that motion. If no
direction has been free for a while, the chair backs up a little. A goal that the user sets, in the viewer or by
`UserInput.Goal`, replaces the place. It needs numpy: the extra `navigate`.

Source:
    The candidate directions and their cost are those of VFH+: Ulrich and Borenstein (1998), VFH+: reliable obstacle
    avoidance for fast mobile robots, ICRA. Its weights are 5 for the goal, 2 for the heading and 2 for the last choice.
    There is no histogram: obstacles are points, and the body is a strip along the direction instead of a disc.
"""

from __future__ import annotations

import math
from typing import Final

from intellwheels_agents.differential_drive import wrapped
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError
from intellwheels_agents.path_follower import BRAKING, TURN_IN_PLACE, TURN_RATE, braking
from intellwheels_agents.portable_math import atan2, cos, hypot, sincos
from intellwheels_agents.range_scan import outline
from intellwheels_agents.user_input import Goals
from intellwheels_agents.user_input import takes_goals as equip
from intellwheels_schemas.extras import missing_extra
from intellwheels_schemas.messages import Actions, Goal, Measures

__all__ = ["Mind", "equip"]

DIRECTIONS: Final = tuple(math.radians(5.0 * k) for k in range(-18, 19))
"""Candidate directions, rad from straight ahead."""
_STRIPS: Final = tuple(sincos(direction) for direction in DIRECTIONS)
GOAL_WEIGHT, HEADING_WEIGHT, LAST_WEIGHT = 5.0, 2.0, 2.0
REACH_SHARES: Final = (1.0, 0.75, 0.5)
"""Shares of the look-ahead, tried one after the other: a direction may be free over a shorter distance only."""
STUCK_TIME: Final = 4.0
"""Time without moving 0.15 m or turning 0.5 rad after which it backs up, s."""
BACKING_TIME: Final = 1.5
"""Time for which it backs up, at 0.2 m/s, s."""


class Mind:
    """Drives to its place."""

    def __init__(self, context: Context) -> None:
        """Read the options.

        Raises:
            OptionError: numpy is missing, the robot has no encoders, or an option is wrong.
        """
        lacking = missing_extra("navigate")
        if lacking is not None:
            raise OptionError(f"mind seek: {lacking}")
        from intellwheels_agents.navigation.collision_guard import CollisionGuard  # noqa: PLC0415 - an extra

        options = context.options
        self._cruise = options.number("speed", 0.6, 0.05, 5.0)
        self._clear = options.number("clear", 0.06, 0.0, 1.0)
        self._within = options.number("within", 0.2, 0.01, 10.0)
        names = options.words("to", "a place of the map; required")
        if len(names) != 1:
            raise OptionError(f"option to: expected a place of the map, got {' '.join(names) or 'none'}")
        place = context.place(names[0], "to")
        self._goal = Goal(x=place.x, y=place.y)
        self._user_goals = Goals()
        self._guard = CollisionGuard(context, "seek", self._cruise, by_itself=True)
        self._body = outline(context.robot)
        self._last = 0.0
        self._arrived = False
        self._side = 0.0
        self._anchor = (0.0, math.inf, 0.0, 0.0)
        self._back_until = -math.inf

    def decide(self, measures: Measures) -> Actions:
        """Return the powers towards the place."""
        self._guard.perceive(measures)
        self._obey(measures)
        pose = self._guard.pose
        dx, dy = self._goal.x - pose.x, self._goal.y - pose.y
        distance, bearing = hypot(dx, dy), wrapped(atan2(dy, dx) - pose.heading)
        if self._arrived or distance <= self._within:
            self._arrived = True
            return self._with_goal(self._guard.drive(0.0, 0.0, "arrived"))
        if measures.time < self._back_until:
            return self._with_goal(self._guard.drive(-0.2, 0.0, "backing"))
        if self._is_stuck(measures.time):
            self._back_until = measures.time + BACKING_TIME
        return self._with_goal(self._towards(bearing, distance))

    def _obey(self, measures: Measures) -> None:
        """Take over a new goal of the user."""
        goal = self._user_goals.changed(measures.user_input)
        if goal is not None:
            self._goal, self._arrived = goal, False
            self._anchor = (measures.time, self._guard.pose.x, self._guard.pose.y, self._guard.pose.turned)

    def _is_stuck(self, time: float) -> bool:
        pose, (since, x, y, turned) = self._guard.pose, self._anchor
        if hypot(pose.x - x, pose.y - y) > 0.15 or abs(pose.turned - turned) > 0.5:
            self._anchor = (time, pose.x, pose.y, pose.turned)
            return False
        if time - since <= STUCK_TIME:
            return False
        self._anchor = (time + BACKING_TIME, pose.x, pose.y, pose.turned)
        return True

    def _with_goal(self, actions: Actions) -> Actions:
        return Actions(
            left_motor=actions.left_motor, right_motor=actions.right_motor, mode=actions.mode, goal=self._goal
        )

    def _towards(self, bearing: float, distance: float) -> Actions:
        reach = self._body.front + min(self._cruise * self._cruise / (2.0 * BRAKING) + 0.8, distance)
        # Points behind the body, or beyond the reach of every strip, block no direction.
        far = reach + self._body.side + self._clear
        lengths = self._guard.free_lengths(_STRIPS, self._body.side + self._clear, reach, far)
        free_lengths = dict(zip(DIRECTIONS, lengths, strict=True))
        for share in REACH_SHARES:
            least = self._body.front + share * (reach - self._body.front)
            free = [direction for direction, length in free_lengths.items() if length >= least]
            if free:
                direction = min(free, key=lambda one: self._cost(one, bearing))
                break
        else:
            # No direction is free: turn to one side, always the same, until one is.
            self._side = self._side or math.copysign(1.0, self._last or bearing)
            return self._guard.drive(0.0, self._side * TURN_RATE, "autonomous")
        self._side = 0.0
        self._last = direction
        if abs(direction) > TURN_IN_PLACE:
            return self._guard.drive(0.0, math.copysign(TURN_RATE, direction), "autonomous")
        speed = min(
            self._cruise, braking(max(0.0, free_lengths[direction] - self._body.front - 0.1)), braking(distance)
        )
        rate = min(max(1.5 * direction, -TURN_RATE), TURN_RATE)
        return self._guard.drive(max(speed, 0.1) * cos(direction), rate, "autonomous")

    def _cost(self, direction: float, bearing: float) -> float:
        off = abs(wrapped(direction - bearing))
        return GOAL_WEIGHT * off + HEADING_WEIGHT * abs(direction) + LAST_WEIGHT * abs(direction - self._last)
