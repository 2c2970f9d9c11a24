"""Drives a path of points and stops at its end.

    points   "x y x y": corners of the path after the start, in metres
    via, to  places of the map; the path goes points, then via in their order, then to
    speed    metres a second on the straight (default 0.6)
    within   metres from the end that count as there (default 0.1)
    stop     metres it keeps from what stands in its way (default 0.5)
    patience seconds it waits after the way became free again (default 1.0)
    lead     true: say each point that is reached, for those who follow (default: false)
    truth    true: know the true pose by a truth sensor, which the simulation must allow (default: own odometry)

Pure pursuit on its own odometry, from encoders and compass. It slows down for what could be in its way and
waits before it, a closed door for one; it does not drive round. A goal that its user sets, in the page or by
`UserInput.Goal`, takes the place of the path: it drives straight there from where it is.
"""

from __future__ import annotations

import math

import msgspec

from intellwheels_agents.differential_drive import Odometry, powers
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.path_follower import CREEP, PathFollower, braking
from intellwheels_agents.pure_pursuit import Path, path_of
from intellwheels_agents.range_scan import RangeScan
from intellwheels_agents.user_input import Goals, takes_goals
from intellwheels_schemas.messages import Actions, Goal, Measures, Robot, Truth

CORNER = math.radians(30.0)
"""A sharper corner is one where what stands straight ahead is not in the way."""
SAY_EVERY = 0.3
"""Metres between two points that a leader says."""
HEARTBEAT = 1.0
"""Seconds between two says of a leader that stands: who hears nothing stops."""


def equip(robot: Robot, options: Options) -> Robot:
    """Return the robot with goals of its user declared, and a truth sensor when the option asks for truth."""
    robot = takes_goals(robot, options)
    if not options.flag("truth") or robot.truth:
        return robot
    return msgspec.structs.replace(robot, truth=(Truth(id="truth"),))


class Mind:
    """Follows its path."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        self._robot = robot
        self._speed = options.number("speed", 0.6, CREEP, 20.0)
        self._within = options.number("within", 0.1, 0.01, 10.0)
        self._stop = options.number("stop", 0.5, 0.05, 10.0)
        self._patience = options.number("patience", 1.0, 0.0, 60.0)
        self._truth = options.flag("truth")
        if not self._truth and not robot.encoders:
            raise OptionError("option truth: expected true for a robot without encoders, got false")
        self._pose = Odometry(robot, context.position)
        self._path = path_of(context)
        self._around = RangeScan(robot)
        self._free_at = 0.0
        self._pilot = PathFollower(self._speed)
        self._leads = options.flag("lead")
        self._said: tuple[float, float, float] | None = None
        self._arrived = self._path is None
        self._goal = None if self._path is None else Goal(x=self._path.end[0], y=self._path.end[1])
        self._wishes = Goals()

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that keep to the path, and for a leader where it is."""
        self._locate(measures)
        self._obey(measures)
        actions = self._drive(measures)
        return actions if not self._leads else msgspec.structs.replace(actions, say=self._point(measures.time))

    def _obey(self, measures: Measures) -> None:
        """Take a goal of its user for the end of a new path."""
        goal = self._wishes.news(measures.user_input)
        if goal is None:
            return
        self._goal = goal
        here, there = (self._pose.x, self._pose.y), (goal.x, goal.y)
        self._arrived = math.dist(here, there) <= self._within / 2.0
        if not self._arrived:
            self._path = Path([here, there])

    def _point(self, time: float) -> str | None:
        """Return where a leader is, for those who follow, when it is time to say so."""
        x, y = self._pose.x, self._pose.y
        if self._said is not None:
            said_x, said_y, said_at = self._said
            if math.dist((x, y), (said_x, said_y)) < SAY_EVERY and time - said_at < HEARTBEAT:
                return None
        self._said = (x, y, time)
        return f"at {x:.3f} {y:.3f}"

    def _drive(self, measures: Measures) -> Actions:
        self._around.update(measures.sensors)
        path, pose = self._path, self._pose
        if path is None or self._arrived:
            return Actions(left_motor=0.0, right_motor=0.0, mode="arrived", goal=self._goal)
        path.update(pose.x, pose.y)
        # The end is reached near it, or abreast of it: driving on would only lead away.
        off = math.dist((pose.x, pose.y), path.end)
        if off <= self._within / 2.0 or path.left <= 1e-3:
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
        steering = self._pilot.steer(path, self._pose, path.left - self._within / 2.0)
        if steering.turns:
            return 0.0, steering.turn_rate, "autonomous"
        allowed = self._allowed(path, time)
        if allowed < CREEP:
            return 0.0, 0.0, "waiting"
        speed = min(steering.speed, allowed)
        return speed, speed * steering.curvature, "autonomous"

    def _allowed(self, path: Path, time: float) -> float:
        """Return the speed that what is ahead allows, in m/s."""
        # What stands behind the end of the path, or straight on where the path turns, is not in the way.
        keep = min(self._stop, path.to_corner(CORNER) + 0.1)
        room = self._around.gap - keep
        if room <= 0.0:
            self._free_at = time + self._patience
            return 0.0
        return braking(room) if time >= self._free_at else 0.0
