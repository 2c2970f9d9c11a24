"""Drives along a path of points and stops at its end.

    points   "x y x y": corners of the path after the start, in the coordinates of the map's site, m
    via, to  places of the map; the path goes through points, then via in their order, then to; at least one of the
             three options is required
    speed    speed on straight stretches, m/s (default 0.6)
    within   distance from the end that counts as arrived, m (default 0.1)
    stop     distance kept from obstacles in the way, m (default 0.5)
    patience seconds that it waits after the way is free again (default 1.0)
    lead     true: say its position as it drives, for agents that follow (default false)
    truth    true: use the true pose from a truth sensor, which the simulation must allow; false: odometry
             (default false)

It follows the path by pure pursuit, with odometry from encoders and compass. It slows down for obstacles that could be
in its way and waits in front of them, a closed door for example; it does not drive around them. A goal that the user
sets, in the viewer or by `UserInput.Goal`, replaces the path: it drives straight there from where it is.
"""

from __future__ import annotations

import math

import msgspec

from intellwheels_agents.differential_drive import Odometry, powers
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.path_follower import MIN_SPEED, PathFollower, braking
from intellwheels_agents.portable_math import dist
from intellwheels_agents.position_message import position_message
from intellwheels_agents.pure_pursuit import Path, path_of
from intellwheels_agents.range_scan import RangeScan
from intellwheels_agents.user_input import Goals, takes_goals
from intellwheels_schemas.messages import Actions, Goal, Measures, Robot, Truth

CORNER = math.radians(30.0)
"""At a sharper corner of the path, obstacles straight ahead are not in the way."""
SAY_DISTANCE = 0.3
"""Distance between two positions that a leader says, m."""
SAY_PERIOD = 1.0
"""Longest time between two messages of a leader, s: its followers stop if they hear nothing."""


def equip(robot: Robot, options: Options) -> Robot:
    """Return the robot with goals declared as user input, and with a truth sensor if the option asks for one."""
    robot = takes_goals(robot, options)
    if not options.flag("truth") or robot.truth:
        return robot
    return msgspec.structs.replace(robot, truth=(Truth(id="truth"),))


class Mind:
    """Drives along its path."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        self._robot = robot
        self._speed = options.number("speed", 0.6, MIN_SPEED, 20.0)
        self._within = options.number("within", 0.1, 0.01, 10.0)
        self._stop = options.number("stop", 0.5, 0.05, 10.0)
        self._patience = options.number("patience", 1.0, 0.0, 60.0)
        self._truth = options.flag("truth")
        if not self._truth and not robot.encoders:
            raise OptionError("option truth: expected true for a robot without encoders, got false")
        self._pose = Odometry(robot, context.position)
        self._path = path_of(context)
        self._scan = RangeScan(robot)
        self._free_at = 0.0
        self._pilot = PathFollower(self._speed)
        self._leads = options.flag("lead")
        self._said: tuple[float, float, float] | None = None
        self._arrived = self._path is None
        self._goal = None if self._path is None else Goal(x=self._path.end[0], y=self._path.end[1])
        self._user_goals = Goals()

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that follow the path and, for a leader, its position as a message."""
        self._locate(measures)
        self._obey(measures)
        actions = self._drive(measures)
        return actions if not self._leads else msgspec.structs.replace(actions, say=self._position(measures.time))

    def _obey(self, measures: Measures) -> None:
        """Replace the path when the user sets a new goal."""
        goal = self._user_goals.changed(measures.user_input)
        if goal is None:
            return
        self._goal = goal
        here, there = (self._pose.x, self._pose.y), (goal.x, goal.y)
        self._arrived = dist(here, there) <= self._within / 2.0
        if not self._arrived:
            self._path = Path([here, there])

    def _position(self, time: float) -> str | None:
        """Return the message with the leader's position, if one is due."""
        x, y = self._pose.x, self._pose.y
        if self._said is not None:
            said_x, said_y, said_at = self._said
            if dist((x, y), (said_x, said_y)) < SAY_DISTANCE and time - said_at < SAY_PERIOD:
                return None
        self._said = (x, y, time)
        return position_message(x, y, 3)

    def _drive(self, measures: Measures) -> Actions:
        self._scan.update(measures.sensors)
        path, pose = self._path, self._pose
        if path is None or self._arrived:
            return Actions(left_motor=0.0, right_motor=0.0, mode="arrived", goal=self._goal)
        path.update(pose.x, pose.y)
        # The end is reached when the chair is near it or abreast of it: driving on would only lead away.
        off = dist((pose.x, pose.y), path.end)
        if off <= self._within / 2.0 or path.remaining <= 1e-3:
            self._arrived = True
            return Actions(left_motor=0.0, right_motor=0.0, mode="arrived", goal=self._goal)
        speed, turn_rate, mode = self._steer(path, measures.time)
        left, right = powers(self._robot, speed, turn_rate)
        return Actions(left_motor=left, right_motor=right, mode=mode, goal=self._goal)

    def _locate(self, measures: Measures) -> None:
        sensors = measures.sensors
        if not self._truth:
            self._pose.update(sensors)
        elif sensors is not None and sensors.truth:
            reading = sensors.truth[0]
            self._pose.x, self._pose.y, self._pose.heading = reading.x, reading.y, reading.heading

    def _steer(self, path: Path, time: float) -> tuple[float, float, str]:
        steering = self._pilot.steer(path, self._pose, path.remaining - self._within / 2.0)
        if steering.turns:
            return 0.0, steering.turn_rate, "autonomous"
        allowed = self._allowed(path, time)
        if allowed < MIN_SPEED:
            return 0.0, 0.0, "waiting"
        speed = min(steering.speed, allowed)
        return speed, speed * steering.curvature, "autonomous"

    def _allowed(self, path: Path, time: float) -> float:
        """Return the speed that the obstacles ahead allow, m/s."""
        # Obstacles beyond the end of the path, or straight on where the path turns, are not in the way.
        standoff = min(self._stop, path.to_corner(CORNER) + 0.1)
        stopping_distance = self._scan.gap - standoff
        if stopping_distance <= 0.0:
            self._free_at = time + self._patience
            return 0.0
        return braking(stopping_distance) if time >= self._free_at else 0.0
