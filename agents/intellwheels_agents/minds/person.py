"""A pedestrian."""

from __future__ import annotations

import math
import random

from intellwheels_agents.differential_drive import Odometry, powers, wrapped
from intellwheels_agents.footprint import Footprint, MovingPoint
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.portable_math import atan2, cos, dist, hypot, sincos
from intellwheels_agents.position_message import position_in, position_message
from intellwheels_agents.pure_pursuit import Point
from intellwheels_agents.range_scan import outline
from intellwheels_agents.scan_tracks import LIDAR, ScanTracks, with_view
from intellwheels_agents.social_force import RELAXATION, attraction, repulsion
from intellwheels_agents.walking_model import (
    HORIZON,
    PASSAGE_TIME_GAP,
    PREFERRED_SPEED,
    TIME_GAP,
    direction,
    gap,
    queue_gap,
)
from intellwheels_agents.walking_route import WalkingRoute
from intellwheels_schemas.messages import Actions, Goal, Map, Measures, Robot

TURN_GAIN = 6.0
"""Turn rate for each radian of heading error, 1/s."""
TURN_RATE = 3.5
"""Highest turn rate, rad/s: half a turn in a second."""
LOOK_AHEAD = 0.3
"""How far a motion of the footprint is checked, s: a turn moves the shoulders."""
MARGIN = 0.03
"""Clearance kept to everything, m."""
BACKWARD = 0.6
"""Speed of stepping back, m/s."""
DODGE_TIME = 0.6
"""Time to a collision at which it gets out of the way of a chair, s."""
ASIDE_TIME, ASIDE_MARGIN = 1.5, 0.1
"""Time to a collision, s, and clearance, m, below which it steps aside from the line of a chair."""
CROWD = 3
"""Objects within `STEP_RANGE` above which it does not jump aside: two people side by side look like a chair."""
STEP_RANGE = 1.5
"""Range within which it checks where it steps, m."""
FASTEST = 1.3
"""Highest speed, as a multiple of the preferred speed."""
STANDING = 0.05
"""Speed below which it stands, m/s."""
PLAN_PERIOD = 0.5
"""Time between two plans of the way, s."""
SAY_PERIOD = 0.5
"""Time between two messages of a walker in a group, s."""
COMPANION_TIMEOUT = 3.0
"""Time after which a silent companion is ignored, s."""
PATIENCE = (0.2, 0.8)
"""Shortest and longest time for which it stands before it yields, s. Each time is drawn anew."""
YIELD_TIME = (0.2, 0.8)
"""Shortest and longest time for which it yields, s; drawn likewise."""
YIELD_SPEED = 0.3
"""Speed at which it steps back when it yields, m/s."""
YIELD_TURN = 1.5
"""Turn rate when it yields, to a side that is drawn or to none, rad/s."""
SLOW = 0.1
"""Speed below which somebody who walks makes no progress, m/s."""
CORNER = 0.25
"""Distance from a corner of the way at which it goes on to the next, m."""
QUEUE_FROM = 3.0
"""Distance from a narrow passage from which it queues, m."""
THROUGH = 0.7
"""Distance from the middle of a passage within which it counts as in the passage, m."""
NEAREST_HORIZON = 0.5
"""Least horizon for a goal that is near, m."""


def equip(robot: Robot, _options: Options) -> Robot:
    """Return the robot with the lidar instead of its own proximity sensors."""
    return with_view(robot)


class Mind:
    """Walks to its goals."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        if not robot.encoders or all(one.id != LIDAR for one in robot.lidar):
            raise OptionError("mind person: expected a robot with encoders and the lidar, got one without")
        self._robot = robot
        self._speed = options.number("speed", PREFERRED_SPEED, STANDING, 5.0)
        self._within = options.number("within", 0.4, 0.01, 10.0)
        self._loop = options.flag("loop")
        self._companions = options.words("with")
        self._shunned = options.words("shun")
        self._goals = context.route()
        self._next = 0
        self._pose = Odometry(robot, context.position)
        self._period = context.parameters.period
        self._view = ScanTracks(self._period)
        body = outline(robot)
        self._front, self._footprint = body.front, Footprint(body)
        self._route = WalkingRoute(context.map if self._goals else Map(format="iw.v1", name="none"))
        self._chairs: list[MovingPoint] = []
        self._way: list[Point] = []
        self._plan_in = 0.0
        self._passage: Point | None = None
        self._random = random.Random(context.agent)  # noqa: S311, not for secrets
        self._heard: dict[str, tuple[float, Point]] = {}
        self._said_at = -math.inf
        self._stuck = 0.0
        self._patience = self._random.uniform(*PATIENCE)
        self._yields = 0.0
        self._yield_turn = 0.0
        fastest = max(self._speed, PREFERRED_SPEED)
        self._dodges = (
            (fastest, 0.0), (-BACKWARD, 0.0), (fastest / 2.0, 2.0), (fastest / 2.0, -2.0),
            (-BACKWARD, 2.0), (-BACKWARD, -2.0), (0.0, 0.0),
        )  # fmt: skip

    def decide(self, measures: Measures) -> Actions:
        """Return the powers that follow the model."""
        pose = self._pose
        old_x, old_y = pose.x, pose.y
        pose.update(measures.sensors)
        self._view.update(measures.sensors, pose)
        speed = dist((old_x, old_y), (pose.x, pose.y)) / self._period
        crowd = self._view.count(pose, STEP_RANGE) > CROWD
        self._chairs = [] if crowd else self._view.large
        self._hear(measures)
        goal = self._goal()
        self._count_stuck(speed, walks=goal is not None)
        left, right = powers(self._robot, *self._walk(*self._wanted(goal)))
        return Actions(
            left_motor=left,
            right_motor=right,
            mode="arrived" if goal is None else "walking",
            goal=None if goal is None else Goal(x=goal[0], y=goal[1]),
            say=self._say(measures.time),
        )

    def _goal(self) -> Point | None:
        """Return the present goal, or None after the last."""
        while self._next < len(self._goals):
            goal = self._goals[self._next]
            if dist(goal, (self._pose.x, self._pose.y)) > self._within:
                return goal
            self._next += 1
            if self._loop and self._next == len(self._goals):
                self._next = 0
                return self._goals[0] if len(self._goals) > 1 else None
        return None

    def _hear(self, measures: Measures) -> None:
        """Remember the positions that companions and those who are shunned say."""
        for message in measures.message:
            known = message.sender in self._companions or message.sender in self._shunned
            point = position_in(message.text) if known else None
            if point is not None:
                self._heard[message.sender] = (measures.time, point)
        self._heard = {
            name: heard for name, heard in self._heard.items() if measures.time - heard[0] < COMPANION_TIMEOUT
        }

    def _emotion(self) -> Point:
        """Return the force of companions and of those who are shunned, m/s2."""
        here = self._pose.x, self._pose.y
        to_x, to_y = attraction(here, [point for name, (_, point) in self._heard.items() if name in self._companions])
        from_x, from_y = repulsion(here, [point for name, (_, point) in self._heard.items() if name in self._shunned])
        return to_x + from_x, to_y + from_y

    def _say(self, time: float) -> str | None:
        """Return the message with its position for the others, if one is due."""
        if not (self._companions or self._shunned) or time - self._said_at < SAY_PERIOD:
            return None
        self._said_at = time
        return position_message(self._pose.x, self._pose.y, 2)

    def _target(self, goal: Point) -> Point:
        """Return the next corner of the way to a goal, or the goal."""
        here = self._pose.x, self._pose.y
        self._plan_in -= self._period
        if self._plan_in <= 0.0 or not self._way or self._way[-1] != goal:
            self._plan_in = PLAN_PERIOD
            self._way = self._route.way(here, goal)
        while len(self._way) > 1 and dist(self._way[0], here) < CORNER:
            self._way.pop(0)
        return self._way[0]

    def _count_stuck(self, speed: float, *, walks: bool) -> None:
        """Count how long it has made no progress; after a random time it yields for a random time."""
        if self._yields > 0.0:
            self._yields -= self._period
        elif speed >= SLOW or not walks:
            self._stuck = max(self._stuck - self._period, 0.0)
        else:
            self._stuck += self._period
            if self._stuck > self._patience:
                self._stuck = 0.0
                self._patience = self._random.uniform(*PATIENCE)
                self._yields = self._random.uniform(*YIELD_TIME)
                self._yield_turn = self._random.choice((-YIELD_TURN, 0.0, YIELD_TURN))

    def _aside(self) -> float | None:
        """Return the direction out of the way of a chair, rad; None if none would hit one who stands."""
        chairs = self._chairs
        if not chairs or (
            self._footprint.free_of_moving(self._near(chairs), 0.0, 0.0, ASIDE_TIME, ASIDE_MARGIN) >= ASIDE_TIME
        ):
            return None
        x, y, velocity_x, velocity_y = (math.fsum(point[i] for point in chairs) for i in range(4))
        # To the side of its line on which it already is.
        left = velocity_y * x - velocity_x * y > 0.0
        return atan2(velocity_x, -velocity_y) if left else atan2(-velocity_x, velocity_y)

    def _wanted(self, goal: Point | None) -> tuple[float, float]:
        """Return the speed (m/s) and turn rate (rad/s) with which it wants to walk."""
        pose, points = self._pose, self._view.points
        aside = self._aside()
        if aside is not None:
            walks_to = direction(points, (), aside, pose.heading, PREFERRED_SPEED, 1.0)
            off = wrapped(walks_to - pose.heading)
            forward = min(self._speed, gap(points, *sincos(walks_to), self._front) / PASSAGE_TIME_GAP)
            return forward * max(cos(off), 0.0), min(max(TURN_GAIN * off, -TURN_RATE), TURN_RATE)
        if goal is None:
            return 0.0, 0.0
        if self._yields > 0.0:
            return -YIELD_SPEED, self._yield_turn
        target = self._target(goal)
        x, y = target[0] - pose.x, target[1] - pose.y
        far = max(hypot(x, y), 1e-9)
        # The velocity at which the force of the goal and those of the others are in balance.
        pull_x, pull_y = self._emotion()
        wanted_x = self._speed * x / far + RELAXATION * pull_x
        wanted_y = self._speed * y / far + RELAXATION * pull_y
        speed = min(hypot(wanted_x, wanted_y), FASTEST * self._speed)
        if speed < STANDING:
            return 0.0, 0.0
        horizon = min(HORIZON, max(far, NEAREST_HORIZON))
        walks_to = direction(points, self._chairs, atan2(wanted_y, wanted_x), pose.heading, speed, horizon)
        off = wrapped(walks_to - pose.heading)
        room, time_gap = gap(points, *sincos(walks_to), self._front), TIME_GAP
        passage = self._route.passage((pose.x, pose.y), target, QUEUE_FROM)
        if passage is not None:
            self._passage, time_gap = passage, PASSAGE_TIME_GAP
            others = [one for one in points if not self._route.on_wall((pose.x + one[0], pose.y + one[1]))]
            room = min(room, queue_gap(others, (passage[0] - pose.x, passage[1] - pose.y)))
        elif self._passage is not None and dist(self._passage, (pose.x, pose.y)) < THROUGH:
            time_gap = PASSAGE_TIME_GAP
        forward = min(speed, room / time_gap) * max(cos(off), 0.0)
        return forward, min(max(TURN_GAIN * off, -TURN_RATE), TURN_RATE)

    def _walk(self, forward: float, turn_rate: float) -> tuple[float, float]:
        """Return the speed (m/s) and turn rate (rad/s) as far as the way is free."""
        large = self._near(self._chairs)
        if self._footprint.free_of_moving(large, 0.0, 0.0, DODGE_TIME, MARGIN) < DODGE_TIME:
            return self._dodge(self._near(self._view.points), forward, turn_rate)
        standing = [(x, y) for x, y, _, _ in self._near(self._view.points)]
        # As wanted, or straight on, or a turn in place, or back to where it can turn.
        for ahead, turn in ((forward, turn_rate), (forward, 0.0), (0.0, turn_rate), (-BACKWARD, 0.0)):
            share = self._footprint.free(standing, ahead, turn, LOOK_AHEAD, MARGIN) / LOOK_AHEAD
            if share > 0.5:
                return ahead * share, turn * share
        return 0.0, 0.0

    def _near(self, points: list[MovingPoint]) -> list[MovingPoint]:
        """Return the points within `STEP_RANGE` in the body frame."""
        s, c = sincos(self._pose.heading)
        return [
            (c * x + s * y, c * y - s * x, c * vx + s * vy, c * vy - s * vx)
            for x, y, vx, vy in points
            if x * x + y * y < STEP_RANGE * STEP_RANGE
        ]

    def _dodge(self, near: list[MovingPoint], forward: float, turn_rate: float) -> tuple[float, float]:
        """Return the speed (m/s) and turn rate (rad/s) that avoid a collision for the longest time."""
        best, longest = (forward, turn_rate), -1.0
        for ahead, turn in ((forward, turn_rate), *self._dodges):
            time = self._footprint.free_of_moving(near, ahead, turn, DODGE_TIME, MARGIN)
            if time > longest:
                best, longest = (ahead, turn), time
            if longest >= DODGE_TIME:
                break
        return best
