"""Walks to its goals among others, by the social force model: drawn by where it wants to be, kept off by what is near.

    points   "x y x y": goals one after the other, in metres
    via, to  places of the map; the goals are points, then via in their order, then to
    speed    metres a second it likes to walk (default 1.34)
    within   metres from a goal that count as there (default 0.4)
    loop     true: begin again with the first goal after the last (default: false)

    dv/dt = (v0 e - v) / tau + sum of f,  f = (V / s) exp(-b / s), away from the thing and beside it

with e the way to the goal and b metres to the middle of the thing. What is behind is felt by half. To one that comes
straight on it steps aside, to the right. And nobody walks faster than lets the gap ahead be kept for `HEADWAY` seconds,
without which a crowd of the model does not slow down as people do.

It perceives by a ring of proximity cones, so a thing is where the ring is nearer than on either side.

Source: D. Helbing, P. Molnar, Social force model for pedestrian dynamics, Phys. Rev. E 51, 1995 (v0, tau, V, s, the half
behind). A. Tordeux, M. Chraibi, A. Seyfried, Collision-free speed model for pedestrian dynamics, Traffic and Granular
Flow '15, 2016 (the headway).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import msgspec

from intellwheels_agents.chair import Odometry, powers, wrapped
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.path import Point
from intellwheels_agents.surroundings import distance, outline
from intellwheels_schemas.messages import Actions, Goal, Measures, Proximity, Robot

CONES = 24
"""Cones all round: narrow enough to tell two people apart at arm's length."""
RING_STEP = 2.0 * math.pi / CONES
SIGHT = 5.0
"""Metres it looks."""
RELAXATION = 0.5
"""Seconds, tau."""
POTENTIAL = 2.1
"""Square metres per square second, V."""
REACH = 0.3
"""Metres, s."""
HALF_DEPTH = 0.2
"""Metres from the surface of a person to its middle."""
BEHIND = 0.5
"""Share by which what lies more than 100 degrees off the way is felt."""
SIGHT_ANGLE = math.radians(100.0)
HEADWAY = 0.8
"""Seconds the gap ahead lasts."""
ELBOW = 0.05
"""Metres kept beside, walking past."""
STEP = 2.0
"""Seconds of a step of somebody else that is reckoned with."""
TO_THE_RIGHT = math.radians(5.0)
"""What is no further than this to the right is straight ahead."""
TRACKING = 0.3
"""Seconds over which the motion of a thing is smoothed."""
SAME = 0.3
"""Metres by which a thing may seem to move in a cycle."""
TURNING = 4.0
"""Radians a second for each radian it must turn."""
TURN_RATE = 3.5
"""Radians a second at most: half a turn in a second."""
STILL = 0.05
"""Metres a second that are not worth a step."""
FASTEST = 1.3
"""Most, in shares of the speed it likes."""


def equip(robot: Robot, _options: Options) -> Robot:
    """Return the robot with the ring of cones in place of its own proximity sensors."""
    width = 360.0 / CONES
    ring = tuple(
        Proximity(id=f"ring-{i}", x=0.0, y=0.0, z=0.4, direction_deg=wrapped_degrees(i * width), cone_deg=width, max_range=SIGHT)
        for i in range(CONES)
    )
    return msgspec.structs.replace(robot, proximity=ring)


def wrapped_degrees(degrees: float) -> float:
    """Return the angle in (-180, 180]."""
    return degrees if degrees <= 180.0 else degrees - 360.0


class Thing(NamedTuple):
    """Somebody or something near.

    Attributes:
        bearing: Of its nearest point, radians in the map's frame.
        metres: To that point.
        toward: Metres a second at which it comes, whatever oneself does.
    """

    bearing: float
    metres: float
    toward: float

    def differs_from(self, other: Thing) -> float:
        """Return how far the nearest points of two things are from each other, seen from one place, m."""
        return abs(self.metres - other.metres) + self.metres * max(abs(wrapped(self.bearing - other.bearing)) - RING_STEP, 0.0)


class Mind:
    """Walks."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        if not robot.encoders or len(robot.proximity) < CONES:
            raise OptionError("mind person: expected a robot with encoders and the ring of cones, got one without")
        self._robot = robot
        self._speed = options.number("speed", 1.34, STILL, 5.0)
        self._within = options.number("within", 0.4, 0.01, 10.0)
        self._loop = options.flag("loop")
        self._goals = _goals(context)
        self._next = 0
        self._pose = Odometry(robot, context.position)
        self._velocity = (0.0, 0.0)
        self._things: list[Thing] = []
        self._period = context.parameters.period
        self._ring = {sensor.id: (i, sensor) for i, sensor in enumerate(robot.proximity)}
        self._bearings = [math.radians(sensor.direction_deg) for sensor in robot.proximity]
        self._ranges = [math.inf] * len(self._bearings)
        body = outline(robot)
        self._side = body.side
        self._extents = [_extent(body.front, body.side, bearing) for bearing in self._bearings]

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that follow the force."""
        pose = self._pose
        was_x, was_y = pose.x, pose.y
        pose.update(measures.sensors)
        self._look(measures)
        self._notice(math.dist((was_x, was_y), (pose.x, pose.y)) / self._period)
        goal = self._goal()
        wanted_x = wanted_y = 0.0
        if goal is not None:
            off = math.dist(goal, (pose.x, pose.y))
            wanted_x, wanted_y = (self._speed * (goal[0] - pose.x) / off, self._speed * (goal[1] - pose.y) / off)
        push_x, push_y = self._push(wanted_x, wanted_y)
        x, y = self._velocity
        share = self._period / RELAXATION
        x += share * (wanted_x - x) + self._period * push_x
        y += share * (wanted_y - y) + self._period * push_y
        fast = math.hypot(x, y) / (FASTEST * self._speed)
        if fast > 1.0:
            x, y = x / fast, y / fast
        self._velocity = (x, y)
        left, right = self._walk(x, y)
        there = goal is None
        return Actions(
            left_motor=left,
            right_motor=right,
            mode="there" if there else "walking",
            goal=None if goal is None else Goal(x=goal[0], y=goal[1]),
        )

    def _goal(self) -> Point | None:
        """Return the goal it walks to, None at the last."""
        while self._next < len(self._goals):
            goal = self._goals[self._next]
            if math.dist(goal, (self._pose.x, self._pose.y)) > self._within:
                return goal
            self._next += 1
            if self._loop and self._next == len(self._goals):
                self._next = 0
                return self._goals[0] if len(self._goals) > 1 else None
        return None

    def _look(self, measures: Measures) -> None:
        if measures.sensors is None:
            return
        for reading in measures.sensors.proximity:
            entry = self._ring.get(reading.id)
            if entry is not None:
                i, sensor = entry
                metres = distance(reading, sensor)
                if metres is not None:
                    self._ranges[i] = metres

    def _notice(self, speed: float) -> None:
        """Find the things in the ring, and how fast each comes nearer by its own doing.

        Args:
            speed: Its own, m/s.
        """
        ranges, count = self._ranges, len(self._ranges)
        known, self._things = self._things, []
        heading = self._pose.heading
        for i, metres in enumerate(ranges):
            before, after = ranges[i - 1], ranges[(i + 1) % count]
            # Of two cones that see one thing at their common edge the first is it.
            if not (metres < before and metres <= after) or metres > SIGHT:
                continue
            bearing = self._bearings[i] + (math.pi / count if metres == after else 0.0)
            thing = Thing(wrapped(heading + bearing), metres, 0.0)
            last = min(known, key=thing.differs_from, default=None)
            if last is not None and thing.differs_from(last) < SAME:
                own = (last.metres - metres) / self._period - speed * math.cos(bearing)
                thing = thing._replace(toward=last.toward + (own - last.toward) * self._period / TRACKING)
            self._things.append(thing)

    def _push(self, wanted_x: float, wanted_y: float) -> tuple[float, float]:
        """Return the sum of the forces of what is near, m/s2, in the map's frame."""
        walks = wanted_x != 0.0 or wanted_y != 0.0
        way = math.atan2(wanted_y, wanted_x) if walks else self._pose.heading
        push_x = push_y = 0.0
        for thing in self._things:
            middle = thing.metres + HALF_DEPTH
            # The ellipse round the thing and where it will be a step later, both seen from here on one line.
            step = STEP * thing.toward
            force = POTENTIAL / REACH * math.exp(-math.sqrt(max(middle * (middle - step), 0.0)) / REACH)
            off = wrapped(thing.bearing - way)
            if walks and abs(off) > SIGHT_ANGLE:
                force *= BEHIND
            push_x -= force * math.cos(thing.bearing)
            push_y -= force * math.sin(thing.bearing)
            if walks and abs(off) < math.pi / 2.0:
                # Round it, on the side it is not: the right for what is straight ahead.
                beside = way + (math.pi / 2.0 if off < -TO_THE_RIGHT else -math.pi / 2.0)
                aside = force * math.cos(off)
                push_x += aside * math.cos(beside)
                push_y += aside * math.sin(beside)
        return push_x, push_y

    def _gap(self) -> float:
        """Return metres to what it would walk into, infinite if there is nothing."""
        gap = math.inf
        for bearing, metres, extent in zip(self._bearings, self._ranges, self._extents, strict=True):
            if abs(bearing) < math.pi / 2.0 and metres * abs(math.sin(bearing)) < self._side + ELBOW:
                gap = min(gap, (metres - extent) * math.cos(bearing))
        return max(gap, 0.0)

    def _walk(self, x: float, y: float) -> tuple[float, float]:
        """Return the powers that turn to a velocity and walk at it as far as there is room."""
        speed = math.hypot(x, y)
        if speed < STILL:
            return 0.0, 0.0
        off = wrapped(math.atan2(y, x) - self._pose.heading)
        turn_rate = min(max(TURNING * off, -TURN_RATE), TURN_RATE)
        forward = min(speed * max(math.cos(off), 0.0), self._gap() / HEADWAY)
        return powers(self._robot, forward, turn_rate)


def _extent(front: float, side: float, bearing: float) -> float:
    """Return metres from the middle of a box to its edge in a direction."""
    c, s = abs(math.cos(bearing)), abs(math.sin(bearing))
    return min(front / c if c > 1e-9 else math.inf, side / s if s > 1e-9 else math.inf)


def _goals(context: Context) -> list[Point]:
    options = context.options
    goals: list[Point] = list(options.points("points"))
    for option in ("via", "to"):
        for name in options.words(option):
            place = context.place(name, option)
            goals.append((place.x, place.y))
    return goals
