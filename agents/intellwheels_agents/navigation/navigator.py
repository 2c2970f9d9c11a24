"""Drives to goals: plans on the map, and chooses every tick the command that is safe among what the sensors see."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Final
from zlib import crc32

import numpy as np
from msgspec import structs

from intellwheels_agents.differential_drive import powers
from intellwheels_agents.mind import Context
from intellwheels_agents.navigation.array_angles import Floats
from intellwheels_agents.navigation.cone_points import ConePoints
from intellwheels_agents.navigation.cost_to_go import CostToGo, Weights
from intellwheels_agents.navigation.footprint_clearance import (
    Box,
    boxes_of,
    clearances,
    covering,
    frame_of,
    hidden_points,
    solids_of,
)
from intellwheels_agents.navigation.giving_way import STALLED, THERE, GivingWay
from intellwheels_agents.navigation.goal_orders import GoalOrders
from intellwheels_agents.navigation.goal_progress import Progress
from intellwheels_agents.navigation.map_distance import MapDistance
from intellwheels_agents.navigation.motion_window import BRAKING_SHARE, MARGIN, MotionWindow
from intellwheels_agents.navigation.moving_tracks import MovingTracks
from intellwheels_agents.navigation.particle_pose import ParticlePose
from intellwheels_agents.navigation.pose_ahead import PoseAhead
from intellwheels_agents.navigation.right_of_way import LENGTH, SAY_PERIOD, way_message
from intellwheels_agents.navigation.scan_points import ScanPoints, into_body, into_map, thinned
from intellwheels_agents.navigation.strange_obstacles import entered
from intellwheels_agents.portable_math import dist, sincos
from intellwheels_agents.user_input import Goals
from intellwheels_agents.wheel_motors import Motors, SafeSpeed
from intellwheels_schemas.messages import Actions, Goal, Map, Measures

CELL: Final = 0.1
"""Size of a cell of the plan, m."""
WORK: Final = 1500
"""Poses of the plan that are expanded in a tick while it drives."""
WORK_ON_DETOUR: Final = 4000
"""The same of a way round: some 3 ms."""
WORK_AT_REST: Final = 14000
"""The same while it waits for the plan: some 9 ms. The whole of a ward of 36 m takes 2.3 s at 20 ticks a second."""
BEYOND: Final = 6.0
"""How far the plan reaches beyond the body, m: so far it may be driven away from its way without a new plan."""
ON_MAP: Final = 0.12
"""Points nearer to something on the map are taken for it, m."""
FARTHEST: Final = 4.0
"""How far the sensors look, m."""
CELLS: Final = ((0.25, 0.02), (0.7, 0.05), (FARTHEST, 0.1))
"""Points nearer to the body than the first number are thinned to cells of the second, m."""
POSES_KEPT: Final = 64
"""Ticks for which poses are kept, for readings that come late."""
INSIST: Final = 6.0
"""Time for which it goes on asking after it has made progress again, s."""
PATIENCE: Final = 2.0
"""Time without progress after which it plans around what stands in the way, s."""
DOOR_RANGE: Final = 2.8
"""Distance at which a door hears that it shall open, m."""

Pose = tuple[float, float, float]
Point = tuple[float, float]


@lru_cache(maxsize=8)
def weights_of(document: Map, boxes: tuple[Box, ...]) -> Weights:
    """Return the costs of the moves of a body on a map; made once for bodies that share them."""
    frame = frame_of(document, CELL)
    return Weights(frame, clearances(frame, solids_of(document), list(boxes)))


class Navigator:
    """Drives one body."""

    def __init__(
        self, context: Context, document: Map, speed: float, within: float, truth: bool, goals: list[Point]
    ) -> None:
        """Prepare the map and the first plan.

        Args:
            context: The agent's context.
            document: The map.
            speed: The highest speed, m/s.
            within: Distance from a goal that counts as arrived, m.
            truth: Whether the pose comes from a truth sensor.
            goals: The goals, m.
        """
        robot = context.robot
        limit = robot.acceleration_limit
        self._robot, self._period, self._within = robot, context.parameters.period, within
        boxes = boxes_of(robot)
        self._solids = solids_of(document)
        self._weights = weights_of(document, tuple(boxes))
        outer = covering(boxes)
        self._speed = min(speed, robot.top_speed)
        self._window = MotionWindow(robot, outer, self._period, speed)
        self._scan = ScanPoints(robot)
        heights = [lidar.z for lidar in robot.lidar] or [sensor.z for sensor in robot.proximity] or [0.4]
        self._map = MapDistance(self._solids, heights[0])
        # What no lidar sees is taken from the map.
        self._unseen = hidden_points(self._solids, boxes, heights[0] if robot.lidar else None)
        self._cones = ConePoints(robot, self._map) if not robot.lidar else None
        self._tracks = MovingTracks(self._period)
        start = context.position
        self._pose: Pose = start.x, start.y, start.heading
        self._estimate = None if truth else ParticlePose(robot, start, self._map, context.agent)
        self._ahead = PoseAhead(robot, self._period, self._pose)
        # It brakes with less than the motors can, as the window does.
        weaker = robot if limit is None else structs.replace(robot, acceleration_limit=BRAKING_SHARE * limit)
        sees = min([FARTHEST, *(lidar.max_range for lidar in robot.lidar)])
        self._safe_speed = SafeSpeed(Motors.of(weaker, self._period), speed, sees - MARGIN)
        self._poses: dict[int, Pose] = {}
        self._goals = list(goals)
        self._user = Goals()
        self._plan: CostToGo | None = None
        self._boxes = boxes
        self._entering: Iterator[Weights | None] | None = None
        self._detour_plan: CostToGo | None = None
        self._map_plan: CostToGo | None = None
        self._progress = Progress()
        self._orders = GoalOrders(context)
        self._doorways = document.doorway
        self._say_limit = context.parameters.say_limit
        self._said_at, self._said_open, self._stalled_at = -1.0, False, 0.0
        self._arrived = False
        self._strange = np.zeros((0, 2))
        # Two chairs that meet must not lose their patience at the same tick.
        self._patience = crc32(context.agent.encode()) % 8 * 0.4
        self._giving = GivingWay(context.agent, self._weights, self._patience)
        while self._goals and not self._planned((start.x, start.y, start.heading)):
            pass

    def decide(self, measures: Measures) -> Actions:
        """Return the actions of a tick."""
        actions = self._decided(measures)
        self._ahead.send(measures.tick, actions)
        return actions

    def _decided(self, measures: Measures) -> Actions:
        time = measures.time
        scans = self._scan.update(measures)
        pose = self._locate(measures, scans)
        self._take_goal(measures)
        points = self._points(measures, scans, pose)
        if not self._goals:
            return self._stand("arrived")
        while len(self._goals) > 1 and self._near(pose, self._goals[0], self._within):
            self._goals.pop(0)
            self._new_plan(time)
        within = self._within * (2.0 if self._arrived else 1.0)
        arrived = len(self._goals) == 1 and self._near(pose, self._goals[0], within)
        self._arrived = arrived
        if not self._planned(pose):
            return self._stand("planning")
        assert self._plan is not None  # noqa: S101 - `_planned` made it
        if arrived:
            self._progress.reset(time)
        else:
            self._progress.update(time, self._plan.at_pose(pose))
            if self._progress.stalled > STALLED:
                self._stalled_at = time
        say = None if arrived else self._say(time, pose)
        aside = self._giving.aside
        door = self._closed_door(pose) if self._progress.stalled > STALLED or aside is not None else None
        self._giving.update(time, pose, measures.message, self._progress.stalled, arrived, door, self._strange)
        if self._giving.aside is not None:
            return self._give_way(self._giving.aside, pose, points, say)
        if aside is not None:
            self._progress.reset(time)
        if arrived:
            return self._stand("arrived")
        self._detour(time, pose)
        slow = self._share()
        choice = self._window.choose(pose, self._plan, points, slow)
        if choice.moves and choice.cost == float("inf"):
            return self._stand("unreachable", say)
        mode = "autonomous" if slow >= 1.0 else "slow"
        return self._answer(mode if choice.moves else "waiting", say)

    def _share(self) -> float:
        """Return the share of the highest speed from which it can stop within what its sensors see."""
        return min(1.0, self._safe_speed.after(self._ahead.blind) / max(self._speed, 1e-6))

    def _take_goal(self, measures: Measures) -> None:
        """Take over a goal of the user or of a message."""
        goal = self._user.changed(measures.user_input)
        new = None if goal is None else (goal.x, goal.y)
        for message in measures.message:
            new = self._orders.goal(message) or new
        if new is not None:
            self._goals, self._arrived = [new], False
            self._new_plan(measures.time)

    def _new_plan(self, time: float) -> None:
        self._plan = self._map_plan = self._entering = self._detour_plan = None
        self._progress.reset(time)

    # ------------------------------------------------------------ others in the way

    def _say(self, time: float, pose: Pose) -> str | None:
        """Return the message that asks a door or others for the way, if one is due."""
        if time - self._said_at < SAY_PERIOD or self._plan is None:
            return None
        door = self._closed_door(pose)
        if door and not self._said_open:
            self._said_at, self._said_open = time, True
            return "open"
        self._said_open = False
        if time - self._stalled_at > INSIST or self._stalled_at == 0.0:
            return None
        self._said_at = time
        way = way_message(self._plan.way(*pose, LENGTH), self._say_limit)
        return way if way != "way" else None

    def _closed_door(self, pose: Pose) -> Point | None:
        """Return the doorway ahead in which something stands that is not on the map."""
        if not self._strange.shape[0]:
            return None
        for doorway in self._doorways:
            x, y = doorway.x - pose[0], doorway.y - pose[1]
            if x * x + y * y > DOOR_RANGE * DOOR_RANGE:
                continue
            off = self._strange - np.array([[doorway.x, doorway.y]])
            if (np.sqrt(off[:, 0] * off[:, 0] + off[:, 1] * off[:, 1]) < 0.4 * doorway.width).any():
                return doorway.x, doorway.y
        return None

    def _give_way(self, aside: CostToGo, pose: Pose, points: Floats, say: str | None) -> Actions:
        cost = self._giving.cost(pose)
        if cost > aside.reached:
            aside.expand(WORK_AT_REST)
            return self._stand("yielding", say)
        if cost < THERE:
            return self._stand("yielding", say)
        self._window.choose(pose, aside, points, self._share())
        return self._answer("yielding", say)

    def _detour(self, time: float, pose: Pose) -> None:
        """Plan around what stands in the way if it has no patience left, while it goes on by the plan that it has."""
        plan = self._detour_plan
        if plan is not None:
            here = plan.at_pose(pose)
            if here > plan.reached:
                plan.expand(WORK_ON_DETOUR)
                return
            self._detour_plan = None
            # If there is no way round, it waits on the way that the map has.
            if here < float("inf"):
                self._map_plan = self._map_plan or self._plan
                self._plan = plan
            self._progress.reset(time)
            return
        if self._entering is None:
            if self._progress.stalled < PATIENCE + self._patience or not self._strange.shape[0]:
                return
            self._entering = entered(self._weights, self._boxes, self._strange)
        copy = next(self._entering)
        if copy is not None:
            self._entering = None
            self._detour_plan = CostToGo.to_point(copy, self._goals[0], self._within / 2.0)

    # ------------------------------------------------------------ answers and plans

    def _stand(self, mode: str, say: str | None = None) -> Actions:
        self._window.stop()
        return self._answer(mode, say)

    def _planned(self, pose: Pose) -> bool:
        """Work on the plan for a tick; return whether it has reached the body."""
        if self._plan is None:
            self._plan = CostToGo.to_point(self._weights, self._goals[0], self._within / 2.0)
        plan = self._plan
        here = plan.at_pose(pose)
        if plan.done and here == float("inf") and self._map_plan is not None:
            # The way round does not lead on from here.
            plan, self._map_plan = self._map_plan, None
            self._plan, here = plan, plan.at_pose(pose)
        ready = here <= plan.reached
        if not plan.done and here + BEYOND > plan.reached:
            plan.expand(WORK if ready else WORK_AT_REST)
        return ready

    def _answer(self, mode: str, say: str | None) -> Actions:
        left, right = powers(self._robot, *self._window.last)
        goal = Goal(x=self._goals[0][0], y=self._goals[0][1]) if self._goals else None
        return Actions(left_motor=left, right_motor=right, mode=mode, goal=goal, say=say)

    def _near(self, pose: Pose, goal: tuple[float, float], within: float) -> bool:
        return dist(pose[:2], goal[:2]) <= within

    def _locate(self, measures: Measures, scans: list[tuple[int, Floats]]) -> Pose:
        if self._estimate is not None:
            self._pose, tick = self._estimate.update(measures, scans), self._estimate.tick
        else:
            tick = measures.tick
            if measures.sensors is not None and measures.sensors.truth:
                reading = measures.sensors.truth[0]
                self._pose = reading.x, reading.y, reading.heading
                tick = tick if reading.tick is None else reading.tick
        ahead = self._ahead
        self._poses.update(ahead.update(measures, self._pose, tick))
        self._poses.pop(measures.tick - POSES_KEPT, None)
        self._window.starts(ahead.speed, ahead.rate)
        return ahead.pose

    def _points(self, measures: Measures, scans: list[tuple[int, Floats]], pose: Pose) -> Floats:
        """Return what is around, as rows x, y, vx, vy in the body's frame."""
        reach = self._window.reach
        seen = []
        for tick, points in scans:
            then = self._poses.get(tick)
            if then is not None:
                seen.append(into_map(points, then))
        if self._cones is not None:
            seen.append(self._cones.update(measures, self._poses))
        found = np.concatenate(seen) if seen else np.zeros((0, 2))
        near = np.abs(found - np.array([[pose[0], pose[1]]])).max(axis=1) < FARTHEST
        found = self._thinned(found[near], pose)
        strange = self._map.at(found[:, 0], found[:, 1]) > ON_MAP
        velocities, growth = np.zeros((found.shape[0], 2)), np.zeros(found.shape[0])
        self._strange = found[strange]
        velocities[strange], growth[strange] = self._tracks.update(self._strange)
        # What moves away may stop at any time, so it counts as standing.
        off = found - np.array([[pose[0], pose[1]]])
        velocities[off[:, 0] * velocities[:, 0] + off[:, 1] * velocities[:, 1] > 0.0] = 0.0
        if self._unseen.shape[0]:
            apart = np.abs(self._unseen - np.array([[pose[0], pose[1]]])).max(axis=1)
            hidden = self._thinned(self._unseen[apart < reach], pose)
            found = np.concatenate([found, hidden])
            velocities = np.concatenate([velocities, np.zeros_like(hidden)])
            growth = np.concatenate([growth, np.zeros(hidden.shape[0])])
        # What moves has moved on until the next command acts.
        found = found + velocities * self._ahead.time
        body = into_body(found, pose)
        speed = np.sqrt(velocities[:, 0] * velocities[:, 0] + velocities[:, 1] * velocities[:, 1])
        gaps = self._window.gaps(body[:, 0], body[:, 1])
        keep = gaps < self._window.reach - 0.5 + 1.6 * speed
        s, c = sincos(pose[2])
        vx, vy = velocities[:, 0], velocities[:, 1]
        return np.stack([body[:, 0], body[:, 1], c * vx + s * vy, c * vy - s * vx, growth], axis=1)[keep]

    def _thinned(self, points: Floats, pose: Pose) -> Floats:
        """Return the nearest of the points of each cell; the nearer to the body, the smaller are the cells."""
        body = into_body(points, pose)
        gaps = self._window.gaps(body[:, 0], body[:, 1])
        order = np.argsort(gaps, kind="stable")
        ends = [int(end) for end in np.searchsorted(gaps[order], [limit for limit, _ in CELLS])]
        parts = zip([0, *ends], ends, CELLS, strict=False)
        return np.concatenate([thinned(points[order[start:end]], size) for start, end, (_, size) in parts])
