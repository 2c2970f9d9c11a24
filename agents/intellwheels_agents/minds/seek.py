"""Drives to a place round what its proximity sensors see.

    to       the place of the map
    speed    metres a second with nothing near (default 0.6)
    clear    metres kept to the side of what it drives past (default 0.06: what `aided` keeps, and a little)
    within   metres from the place that count as there (default 0.2)
    and of `aided`: margin, ahead

It knows the way to the place by its own odometry alone, and what stands in the way by its proximity sensors alone. Of
the directions in which the body fits it takes the one that costs least; what it then wants is slowed and stopped as a
user's wish is by `aided`. When nothing is free for a while it goes back a little. A goal that its user sets, in the
page or by `UserInput.Goal`, takes the place of the place.

Source:
    The candidate directions and their cost are those of VFH+: Ulrich and Borenstein (1998), VFH+: reliable obstacle
    avoidance for fast mobile robots, ICRA; its weights are 5 for the goal, 2 for the heading and 2 for the last choice.
    The histogram is left out: what was seen is kept as points, and the body is a strip along the direction, not a disc.
"""

from __future__ import annotations

import math
from typing import Final

from intellwheels_agents.differential_drive import wrapped
from intellwheels_agents.mind import Context
from intellwheels_agents.minds.aided import Mind as Guard
from intellwheels_agents.options import OptionError
from intellwheels_agents.path_follower import BRAKING, TURN_RATE, braking
from intellwheels_agents.range_scan import outline
from intellwheels_agents.user_input import Goals
from intellwheels_agents.user_input import takes_goals as equip
from intellwheels_schemas.messages import Actions, Goal, Measures

__all__ = ["Mind", "equip"]

DIRECTIONS: Final = tuple(math.radians(5.0 * k) for k in range(-18, 19))
GOAL, AHEAD, LAST = 5.0, 2.0, 2.0
TURNS: Final = math.radians(50.0)
"""A direction further to the side is turned to in place."""
NARROW: Final = (1.0, 0.75, 0.5)
"""Shares of the reach that are tried in turn: where nothing is free so far, something may be less far."""
STUCK: Final = 4.0
"""Seconds without moving 0.15 m or turning 0.5 rad after which it goes back."""
BACK: Final = 1.5
"""Seconds for which it goes back, at 0.2 m/s."""


class Mind:
    """Seeks its place."""

    def __init__(self, context: Context) -> None:
        options = context.options
        self._cruise = options.number("speed", 0.6, 0.05, 5.0)
        self._clear = options.number("clear", 0.06, 0.0, 1.0)
        self._within = options.number("within", 0.2, 0.01, 10.0)
        names = options.words("to")
        if len(names) != 1:
            raise OptionError(f"option to: expected a place of the map, got {' '.join(names) or 'none'}")
        place = context.place(names[0], "to")
        self._goal = Goal(x=place.x, y=place.y)
        self._wishes = Goals()
        self._guard = Guard(context, by_itself=True)
        self._body = outline(context.robot)
        self._last = 0.0
        self._arrived = False
        self._near: list[tuple[float, float]] = []
        self._side = 0.0
        self._anchor = (0.0, math.inf, 0.0, 0.0)
        self._back_until = -math.inf

    def decide(self, measures: Measures) -> Actions:
        """Return the powers towards the place."""
        self._guard.perceive(measures)
        self._obey(measures)
        pose = self._guard.pose
        dx, dy = self._goal.x - pose.x, self._goal.y - pose.y
        distance, bearing = math.hypot(dx, dy), wrapped(math.atan2(dy, dx) - pose.heading)
        if self._arrived or distance <= self._within:
            self._arrived = True
            return self._with_goal(self._guard.drive(0.0, 0.0, "arrived"))
        if measures.time < self._back_until:
            return self._with_goal(self._guard.drive(-0.2, 0.0, "backing"))
        if self._is_stuck(measures.time):
            self._back_until = measures.time + BACK
        return self._with_goal(self._towards(bearing, distance))

    def _obey(self, measures: Measures) -> None:
        """Seek what its user wants from now on."""
        goal = self._wishes.news(measures.user_input)
        if goal is not None:
            self._goal, self._arrived = goal, False
            self._anchor = (measures.time, self._guard.pose.x, self._guard.pose.y, self._guard.pose.turned)

    def _is_stuck(self, time: float) -> bool:
        pose, (since, x, y, turned) = self._guard.pose, self._anchor
        if math.hypot(pose.x - x, pose.y - y) > 0.15 or abs(pose.turned - turned) > 0.5:
            self._anchor = (time, pose.x, pose.y, pose.turned)
            return False
        if time - since <= STUCK:
            return False
        self._anchor = (time + BACK, pose.x, pose.y, pose.turned)
        return True

    def _with_goal(self, actions: Actions) -> Actions:
        return Actions(
            left_motor=actions.left_motor, right_motor=actions.right_motor, mode=actions.mode, goal=self._goal
        )

    def _towards(self, bearing: float, distance: float) -> Actions:
        reach = self._body.front + min(self._cruise**2 / (2.0 * BRAKING) + 0.8, distance)
        # What is behind, or further off than any strip reaches, is in no direction's way.
        far = reach + self._body.side + self._clear
        self._near = [point for point in self._guard.seen.points if point[0] > -1.0 and math.hypot(*point) < far]
        rooms = {direction: self._room(direction, reach) for direction in DIRECTIONS}
        for share in NARROW:
            least = self._body.front + share * (reach - self._body.front)
            free = [direction for direction, room in rooms.items() if room >= least]
            if free:
                direction = min(free, key=lambda one: self._cost(one, bearing))
                break
        else:
            # Nowhere to go: it turns to the side it once chose until there is.
            self._side = self._side or math.copysign(1.0, self._last or bearing)
            return self._guard.drive(0.0, self._side * TURN_RATE, "autonomous")
        self._side = 0.0
        self._last = direction
        if abs(direction) > TURNS:
            return self._guard.drive(0.0, math.copysign(TURN_RATE, direction), "autonomous")
        speed = min(self._cruise, braking(max(0.0, rooms[direction] - self._body.front - 0.1)), braking(distance))
        rate = min(max(1.5 * direction, -TURN_RATE), TURN_RATE)
        return self._guard.drive(max(speed, 0.1) * math.cos(direction), rate, "autonomous")

    def _cost(self, direction: float, bearing: float) -> float:
        off = abs(wrapped(direction - bearing))
        return GOAL * off + AHEAD * abs(direction) + LAST * abs(direction - self._last)

    def _room(self, direction: float, reach: float) -> float:
        """Return how far the body's strip in a direction is free, metres from its centre, at most `reach`."""
        c, s = math.cos(direction), math.sin(direction)
        half = self._body.side + self._clear
        room = reach
        for x, y in self._near:
            along = c * x + s * y
            if 0.0 < along < room and abs(c * y - s * x) < half:
                room = along
        return room
