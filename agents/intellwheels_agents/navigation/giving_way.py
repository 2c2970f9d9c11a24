"""Drives off the way of others, and out of the swing of a door, and comes back when they have passed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from intellwheels_agents.navigation.array_angles import Floats
from intellwheels_agents.navigation.cost_to_go import CostToGo, Weights, distances
from intellwheels_agents.navigation.goal_progress import Progress
from intellwheels_agents.navigation.right_of_way import ROOM, RightOfWay
from intellwheels_agents.navigation.scan_points import Pose, thinned
from intellwheels_agents.portable_math import dist
from intellwheels_schemas.messages import Heard

STALLED: Final = 1.5
"""Time without progress after which it gives way, s."""
DOOR_ROOM: Final = 1.4
"""Distance to a closed door at which its leaf can swing, m."""
RETHINK: Final = 5.0
"""Time after which a place to go to is chosen again, s."""
LONGEST: Final = 8.0
"""Longest way to such a place, m."""
STUBBORN: Final = 3.0
"""Time without progress after which it stops giving way, and the least time for which it does, s."""
WIDTH: Final = 0.5
"""Width of the band of places around a way, m."""
APART: Final = 0.6
"""Distance of a place from things that are not on the map, m."""
MOVED: Final = 0.4
"""A chair that stays within this distance does not move, m."""
STUCK: Final = 9.0
"""Time without moving after which it backs out of where it is, s."""
OUT: Final = 6.0
"""Time for which it backs out, s."""
OUT_ROOM: Final = 1.3
"""Distance to which it backs out, m."""
ANEW: Final = 0.8
"""Distance to which it backs out where only the map is in its way, m."""
THERE: Final = 0.1
"""Cost from which it is at the place, m."""

Point = tuple[float, float]


class GivingWay:
    """When one chair gives way, and where it goes.

    Attributes:
        aside: Costs to the places where it is out of the way; None if it is in nobody's way, or cannot get out of it.
    """

    def __init__(self, name: str, weights: Weights, patience: float) -> None:
        """Take the chair's name, the costs of its moves, and how much longer than others it is stubborn, s."""
        self.aside: CostToGo | None = None
        self._ways = RightOfWay(name)
        self._weights, self._patience = weights, patience
        self._since = self._stubborn_until = 0.0
        self._was_arrived = False
        self._progress = Progress()
        self._anchor: Point = (float("inf"), 0.0)
        self._anchored = self._out_until = 0.0

    def update(
        self,
        time: float,
        pose: Pose,
        messages: Sequence[Heard],
        stalled: float,
        arrived: bool,
        door: Point | None,
        strange: Floats,
    ) -> None:
        """Decide for a tick.

        Args:
            time: Simulated time, s.
            pose: The pose of the chair.
            messages: What it heard.
            stalled: For how long it has made no progress, s.
            arrived: Whether it is at its goal.
            door: A doorway ahead that something closes.
            strange: What it sees that is not on the map, m.
        """
        self._ways.update(time, messages)
        if self._out_until <= time < self._stubborn_until:
            self.aside = None
            return
        self._watch(time, pose, arrived)
        points, room = self._to_clear(time, pose, stalled, arrived, door, strange)
        if not points:
            self.aside, self._was_arrived = None, False
            return
        if self.aside is None or time - self._since > RETHINK:
            self._was_arrived = self._was_arrived or arrived
            apart = APART if room < OUT_ROOM else OUT_ROOM
            self.aside, self._since = self._out_of(points, room, pose, strange, apart), time
            self._progress.reset(time)
        self._give_up(time, self.cost(pose))

    def cost(self, pose: Pose) -> float:
        """Return the cost to the nearest place, m; infinite if none is known."""
        return float("inf") if self.aside is None else self.aside.at_pose(pose)

    def _watch(self, time: float, pose: Pose, arrived: bool) -> None:
        """Note when it has hardly moved for so long that it must back out of where it is."""
        if arrived or dist(pose[:2], self._anchor[:2]) > MOVED:
            self._anchor, self._anchored = (pose[0], pose[1]), time
        elif time - self._anchored > STUCK + self._patience:
            self._out_until, self._anchored, self.aside = time + OUT, time + OUT, None

    def _to_clear(
        self, time: float, pose: Pose, stalled: float, arrived: bool, door: Point | None, strange: Floats
    ) -> tuple[list[Point], float]:
        """Return the points to leave free, and the distance to them, m."""
        if time < self._out_until:
            near = strange[np.abs(strange - np.array([[pose[0], pose[1]]])).max(axis=1) < 2.0]
            if near.shape[0]:
                return [(x, y) for x, y in thinned(near, 0.2).tolist()], OUT_ROOM
            # Nothing but the map is near: it comes back to the narrow place from another side.
            return [self._anchor], ANEW
        away = self.aside is not None
        points = self._ways.to_clear(
            (pose[0], pose[1]),
            away or stalled > STALLED,
            arrived or self._was_arrived,
            1.5 * ROOM if away else ROOM,
        )
        at_door = door is not None and dist(pose[:2], door[:2]) < 1.2 * DOOR_ROOM
        if not points and door is not None and at_door and (away or stalled > STALLED):
            return [door], DOOR_ROOM
        return points, 1.1 * ROOM

    def _give_up(self, time: float, cost: float) -> None:
        """Stay on the own way if there is no place to go to, or the chair does not get there."""
        aside = self.aside
        if aside is None:
            return
        if THERE < cost <= aside.reached:
            self._progress.update(time, cost)
            if self._progress.stalled > STUBBORN:
                # Perhaps the others can move if it goes on.
                self._stubborn_until = time + STUBBORN + self._patience
        else:
            self._progress.reset(time)
        if cost > aside.reached > LONGEST or (aside.done and cost == float("inf")):
            self._stubborn_until = time + STUBBORN
        if self._stubborn_until > time:
            self.aside = None

    def _out_of(self, points: list[Point], room: float, pose: Pose, strange: Floats, apart: float) -> CostToGo:
        frame, clearance = self._weights.frame, self._weights.clearance
        off, near = distances(frame, points), distances(frame, [(pose[0], pose[1])])
        band = (off > room) & (off < room + WIDTH) & (near < LONGEST)
        if strange.shape[0]:
            others = [(x, y) for x, y in thinned(strange, 0.2).tolist()]
            band &= distances(frame, others) > min(apart, room)
        ends = np.zeros(clearance.shape, dtype=bool)
        ends[::2] = (clearance[::2] >= 0.05) & band
        return CostToGo(self._weights, ends)
