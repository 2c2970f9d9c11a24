"""Follows a leader along the points it says.

    leader   the agent that is followed: a `waypoints` with lead=true, or whoever says "at X Y" in metres
    gap      metres kept to the leader's last point, along its path (default 2.0)
    speed    metres a second on the straight (default 0.8)
    stop     metres kept from what stands in the way (default 0.4)
    silence  seconds without a word of the leader after which it stops (default 3.0)

It drives by what it hears and by its own odometry, and does not look for the leader. It begins where it stands and
takes the straight way to the first point it hears.
"""

from __future__ import annotations

import re

from intellwheels_agents.differential_drive import Odometry, powers
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError
from intellwheels_agents.path_follower import CREEP, PathFollower, braking
from intellwheels_agents.pure_pursuit import Path, Point
from intellwheels_agents.range_scan import RangeScan
from intellwheels_schemas.messages import Actions, Goal, Measures

_NUMBER = r"(-?\d{1,5}(?:\.\d{1,9})?)"
_POINT = re.compile(rf"at {_NUMBER} {_NUMBER}")


def point_in(text: str) -> Point | None:
    """Return the point that a leader says, or None where the words are none."""
    found = _POINT.fullmatch(text)
    return (float(found.group(1)), float(found.group(2))) if found else None


class Mind:
    """Follows its leader."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        if not robot.encoders:
            raise OptionError("mind follow: expected a robot with encoders, got one without")
        self._robot = robot
        leaders = options.words("leader") or ("leader",)
        if len(leaders) != 1:
            raise OptionError(f"option leader: expected one name, got {' '.join(leaders)!r}")
        (self._leader,) = leaders
        self._gap = options.number("gap", 2.0, 0.1, 100.0)
        self._stop = options.number("stop", 0.4, 0.05, 10.0)
        self._silence = options.number("silence", 3.0, 0.1, 60.0)
        self._pilot = PathFollower(options.number("speed", 0.8, CREEP, 20.0))
        self._pose = Odometry(robot, context.position)
        self._around = RangeScan(robot)
        self._path: Path | None = None
        self._heard_at: float | None = None

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that keep to the leader's path, at a distance."""
        self._pose.update(measures.sensors)
        self._around.update(measures.sensors)
        self._listen(measures)
        if self._path is None or self._heard_at is None:
            return Actions(left_motor=0.0, right_motor=0.0, mode="listening")
        path = self._path
        path.update(self._pose.x, self._pose.y)
        goal = Goal(x=path.end[0], y=path.end[1])
        if measures.time - self._heard_at >= self._silence:
            return Actions(left_motor=0.0, right_motor=0.0, mode="silent", goal=goal)
        room = min(path.left - self._gap, self._around.gap - self._stop)
        if braking(room) < CREEP:
            return Actions(left_motor=0.0, right_motor=0.0, mode="near", goal=goal)
        steering = self._pilot.steer(path, self._pose, room)
        turn_rate = steering.turn_rate if steering.turns else steering.speed * steering.curvature
        left, right = powers(self._robot, steering.speed, turn_rate)
        return Actions(left_motor=left, right_motor=right, mode="following", goal=goal)

    def _listen(self, measures: Measures) -> None:
        for words in measures.message:
            point = point_in(words.text) if words.sender == self._leader else None
            if point is None:
                continue
            self._heard_at = measures.time
            if self._path is not None:
                self._path.extend(point)
            elif point != (self._pose.x, self._pose.y):
                self._path = Path([(self._pose.x, self._pose.y), point])
