"""Drives a path of points and stops at its end.

    points   "x y x y": corners of the path after the start, in metres
    via, to  places of the map; the path goes points, then via in their order, then to
    speed    metres a second on the straight (default 0.6)
    within   metres from the end that count as there (default 0.1)
    stop     metres it keeps from what stands in its way (default 0.5)
    patience seconds it waits after the way became free again (default 1.0)
    truth    true: know the true pose by a truth sensor, which the simulation must allow (default: own odometry)

Pure pursuit on its own odometry, from encoders and compass. It slows down for what could be in its way and
waits before it, a closed door for one; it does not drive round.
"""

from __future__ import annotations

import math

import msgspec

from intellwheels_agents.chair import Odometry, powers, wrapped
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.path import Path, Point
from intellwheels_agents.surroundings import Surroundings
from intellwheels_schemas.messages import Actions, Goal, Measures, Robot, Truth

TURN_RATE = 0.8
"""Radians a second at most."""
TURN_IN_PLACE = math.radians(50.0)
"""When the target lies further to the side than this the chair turns before it drives."""
CORNER = math.radians(30.0)
"""A sharper corner is one where what stands straight ahead is not in the way."""
BRAKING = 0.35
"""Metres a second squared: gentle to who sits in the chair."""
CREEP = 0.05
"""Metres a second: the least that is worth moving."""


def equip(robot: Robot, options: Options) -> Robot:
    """Return the robot with a truth sensor, when the option asks for truth."""
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
        self._path = _path(context)
        self._around = Surroundings(robot)
        self._free_at = 0.0
        self._turning = False
        self._arrived = self._path is None
        self._goal = None if self._path is None else Goal(x=self._path.end[0], y=self._path.end[1])

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that keep to the path."""
        self._locate(measures)
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
        pose = self._pose
        reach = max(0.45, 0.9 * self._speed)
        target_x, target_y = path.ahead(reach)
        dx, dy = target_x - pose.x, target_y - pose.y
        bearing = wrapped(math.atan2(dy, dx) - pose.heading)
        # Two thresholds, or it would begin to drive and to turn by turns.
        self._turning = abs(bearing) > (TURN_IN_PLACE / 3.0 if self._turning else TURN_IN_PLACE)
        if self._turning:
            return 0.0, _limited(2.0 * bearing, TURN_RATE), "autonomous"
        curvature = 2.0 * math.sin(bearing) / max(math.hypot(dx, dy), 1e-3)
        speed = min(self._speed, TURN_RATE / max(abs(curvature), 1e-6), _braking(path.left - self._within / 2.0))
        speed = max(speed, CREEP)
        allowed = self._allowed(path, time)
        if allowed < CREEP:
            return 0.0, 0.0, "waiting"
        speed = min(speed, allowed)
        return speed, speed * curvature, "autonomous"

    def _allowed(self, path: Path, time: float) -> float:
        """Return the speed that what is ahead allows, in m/s."""
        # What stands behind the end of the path, or straight on where the path turns, is not in the way.
        keep = min(self._stop, path.to_corner(CORNER) + 0.1)
        room = self._around.gap - keep
        if room <= 0.0:
            self._free_at = time + self._patience
            return 0.0
        return _braking(room) if time >= self._free_at else 0.0


def _braking(distance: float) -> float:
    return math.sqrt(2.0 * BRAKING * max(distance, 0.0))


def _limited(value: float, most: float) -> float:
    return min(max(value, -most), most)


def _path(context: Context) -> Path | None:
    options = context.options
    points: list[Point] = [(context.position.x, context.position.y), *options.points("points")]
    names = [(name, "via") for name in options.words("via")] + [(name, "to") for name in options.words("to")]
    for name, option in names:
        place = context.place(name, option)
        points.append((place.x, place.y))
    if len(points) == 1:
        raise OptionError("option points: expected points, via or to, got none")
    try:
        return Path(points)
    except ValueError:
        # The start is the end: there already.
        return None
