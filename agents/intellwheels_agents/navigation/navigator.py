"""Drives to goals: plans on the map, and chooses every tick the command that is safe among what the sensors see."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np

from intellwheels_agents.differential_drive import Odometry, powers
from intellwheels_agents.mind import Context
from intellwheels_agents.navigation.cost_to_go import CostToGo, Weights
from intellwheels_agents.navigation.exact_angles import Floats, sine_cosine
from intellwheels_agents.navigation.footprint_clearance import (
    Box,
    boxes_of,
    clearances,
    covering,
    frame_of,
    points_along,
    solids_of,
)
from intellwheels_agents.navigation.map_distance import MapDistance
from intellwheels_agents.navigation.motion_window import MotionWindow
from intellwheels_agents.navigation.moving_tracks import MovingTracks
from intellwheels_agents.navigation.scan_points import ScanPoints, into_body, into_map, thinned
from intellwheels_agents.user_input import Goals
from intellwheels_schemas.messages import Actions, Goal, Map, Measures

CELL: Final = 0.1
"""Size of a cell of the plan, m."""
WORK: Final = 1500
"""Poses of the plan that are expanded in a tick while it drives."""
WORK_AT_REST: Final = 6000
"""Poses of the plan that are expanded in a tick while it waits for the plan."""
BEYOND: Final = 6.0
"""How far the plan reaches beyond the body, m: so far it may be driven away from its way without a new plan."""
ON_MAP: Final = 0.12
"""Points nearer to something on the map are taken for it, m."""
POSES_KEPT: Final = 64

Pose = tuple[float, float, float]


@lru_cache(maxsize=8)
def weights_of(document: Map, boxes: tuple[Box, ...]) -> Weights:
    """Return the costs of the moves of a body on a map; made once for bodies that share them."""
    frame = frame_of(document, CELL)
    return Weights(frame, clearances(frame, solids_of(document), list(boxes)))


class Navigator:
    """Drives one body."""

    def __init__(self, context: Context, document: Map, speed: float, within: float, goals: list[tuple[float, float]]) -> None:
        robot = context.robot
        self._robot, self._period, self._within = robot, context.parameters.period, within
        boxes = boxes_of(robot)
        self._solids = solids_of(document)
        self._weights = weights_of(document, tuple(boxes))
        outer = covering(boxes)
        self._window = MotionWindow(robot, outer, self._period, speed)
        self._scan = ScanPoints(robot)
        heights = [lidar.z for lidar in robot.lidar] or [sensor.z for sensor in robot.proximity] or [0.4]
        self._map = MapDistance(self._solids, heights[0])
        unseen = [
            points_along(solid, 0.04)
            for solid in self._solids
            if not solid.bottom <= heights[0] < solid.top and any(b.bottom < solid.top and solid.bottom < b.top for b in boxes)
        ]
        self._unseen = np.concatenate(unseen) if unseen else np.zeros((0, 2))
        self._tracks = MovingTracks(self._period)
        self._odometry = Odometry(robot, context.position)
        self._poses: dict[int, Pose] = {}
        self._goals = list(goals)
        self._user = Goals()
        self._plan: CostToGo | None = None
        start = context.position
        while self._goals and not self._planned((start.x, start.y, start.heading)):
            pass

    def decide(self, measures: Measures) -> Actions:
        """Return the actions of a tick."""
        pose = self._locate(measures)
        self._poses[measures.tick] = pose
        self._poses.pop(measures.tick - POSES_KEPT, None)
        while len(self._goals) > 1 and self._near(pose, self._goals[0], self._within):
            self._goals.pop(0)
            self._plan = None
        if not self._goals or self._near(pose, self._goals[0], self._within):
            self._window.stop()
            return self._answer("arrived", measures)
        points = self._points(measures, pose)
        if not self._planned(pose):
            self._window.stop()
            return self._answer("planning", measures)
        assert self._plan is not None
        choice = self._window.choose(pose, self._plan, points)
        return self._answer("autonomous" if choice.moves else "waiting", measures)

    def _planned(self, pose: Pose) -> bool:
        """Work on the plan for a tick; return whether it has reached the body."""
        if self._plan is None:
            self._plan = CostToGo(self._weights, self._goals[0], self._within / 2.0)
        plan = self._plan
        here = self._cost(plan, pose)
        ready = here <= plan.reached
        if not plan.done and here + BEYOND > plan.reached:
            plan.expand(WORK if ready else WORK_AT_REST)
        return ready

    def _cost(self, plan: CostToGo, pose: Pose) -> float:
        return float(plan.at(np.array([pose[0]]), np.array([pose[1]]), np.array([pose[2]]))[0])

    def _answer(self, mode: str, measures: Measures) -> Actions:
        left, right = powers(self._robot, *self._window.last)
        goal = Goal(x=self._goals[0][0], y=self._goals[0][1]) if self._goals else None
        return Actions(left_motor=left, right_motor=right, mode=mode, goal=goal)

    def _near(self, pose: Pose, goal: tuple[float, float], within: float) -> bool:
        return (pose[0] - goal[0]) ** 2 + (pose[1] - goal[1]) ** 2 <= within * within

    def _locate(self, measures: Measures) -> Pose:
        sensors = measures.sensors
        self._window.measured(None, None)
        if sensors is not None and sensors.truth:
            reading = sensors.truth[0]
            return reading.x, reading.y, reading.heading
        self._odometry.update(sensors)
        return self._odometry.x, self._odometry.y, self._odometry.heading

    def _points(self, measures: Measures, pose: Pose) -> Floats:
        """Return what is around, as rows x, y, vx, vy in the body's frame."""
        reach = self._window.reach
        seen = []
        for tick, points in self._scan.update(measures):
            then = self._poses.get(tick)
            if then is not None:
                seen.append(into_map(points, then))
        found = np.concatenate(seen) if seen else np.zeros((0, 2))
        near = (found[:, 0] - pose[0]) ** 2 + (found[:, 1] - pose[1]) ** 2 < 16.0
        found = thinned(found[near])
        strange = self._map.at(found[:, 0], found[:, 1]) > ON_MAP
        velocities = np.zeros((found.shape[0], 2))
        velocities[strange] = self._tracks.update(found[strange])
        if self._unseen.shape[0]:
            off = np.abs(self._unseen - np.array([[pose[0], pose[1]]])).max(axis=1)
            hidden = self._unseen[off < reach]
            found = np.concatenate([found, hidden])
            velocities = np.concatenate([velocities, np.zeros_like(hidden)])
        body = into_body(found, pose)
        speed = np.sqrt(velocities[:, 0] ** 2 + velocities[:, 1] ** 2)
        gaps = self._window.gaps(body[:, 0], body[:, 1])
        keep = gaps < self._window.reach - 0.5 + 1.6 * speed
        s, c = sine_cosine(pose[2])
        vx, vy = velocities[:, 0], velocities[:, 1]
        return np.stack([body[:, 0], body[:, 1], c * vx + s * vy, c * vy - s * vx], axis=1)[keep]
