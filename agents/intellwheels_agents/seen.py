"""Where something may stand around a body, remembered from its proximity sensors.

A reading says how near something is inside a cone, not where in it: every point of the arc at that distance may be it.
The arc is kept as points, carried along by odometry, until a later cone proves a point free by seeing past it, the body
itself stands there, or it is left behind. So what slips between two cones is still known, once one of them saw it.

What no cone ever saw is not known: a thin thing that appears between two cones, or above or below their height.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple

from intellwheels_agents.chair import Odometry
from intellwheels_agents.surroundings import Outline, distance, outline
from intellwheels_schemas.messages import Measures, Proximity, ProximityReading, Robot

CELL: Final = 0.03
"""Metres of the raster in which one point is kept. Its diagonal is less than `PROOF`."""
SPACING: Final = 0.05
"""Metres between the points of an arc."""
PROOF: Final = 0.05
"""Metres by which a cone must see past a point, and hold it within its edges, to prove it free: whatever stood in the
point's cell, or between it and the next of its arc, would have been seen."""
REACH: Final = 2.0
"""Metres up to which a reading is kept: what is further is seen again, nearer, before it matters."""
FORGOTTEN: Final = 8.0
"""Metres of driving, a radian of turning counted as one, after which odometry is trusted no more."""
_PAST: Final = 40

Pose = tuple[float, float, float]


class _Eye(NamedTuple):
    """A sensor on the body: place, direction, and its cone's half angle as tangent and lengths of the proof."""

    sensor: Proximity
    x: float
    y: float
    bearing: float
    half: float
    tangent: float
    slack: float


class Seen:
    """What may stand around a body.

    Attributes:
        points: (x, y) in the body's own frame, metres, of all that may be something within `REACH` of the body.
    """

    def __init__(self, robot: Robot) -> None:
        """Take the sensors of `robot` that ride on it."""
        self.points: list[tuple[float, float]] = []
        self._outline = outline(robot)
        self._eyes = {sensor.id: _eye(sensor) for sensor in robot.proximity if sensor.mount == "body"}
        self._cells: dict[tuple[int, int], tuple[float, float, float]] = {}
        self._poses: deque[tuple[int, Pose]] = deque(maxlen=_PAST)
        self._travel = 0.0

    def update(self, measures: Measures, odometry: Odometry) -> None:
        """Take the readings of a tick.

        Args:
            measures: A reading that says an older tick is put where the body was then.
            odometry: Updated with the same measures.
        """
        pose = odometry.x, odometry.y, odometry.heading
        if self._poses:
            x, y, heading = self._poses[-1][1]
            turned = math.remainder(pose[2] - heading, math.tau)
            self._travel += math.hypot(pose[0] - x, pose[1] - y) + abs(turned)
        self._poses.append((measures.tick, pose))
        local = self._around(pose)
        for reading in measures.sensors.proximity if measures.sensors else ():
            eye = self._eyes.get(reading.id)
            metres = None if eye is None else distance(reading, eye.sensor)
            if eye is None or metres is None:
                continue
            then = self._pose_at(reading.tick)
            if then is None:
                continue
            # What is seen anew was not there before; only what sees the room as it is now proves it free.
            if then == pose:
                self._prove_free(eye, min(metres, eye.sensor.max_range), local)
            self._mark(eye, reading, metres, then)
        self.points = [(x, y) for x, y, _ in self._around(pose)]

    def _pose_at(self, tick: int | None) -> Pose | None:
        if tick is None:
            return self._poses[-1][1]
        return next((pose for at, pose in self._poses if at == tick), None)

    def _around(self, pose: Pose) -> list[tuple[float, float, tuple[int, int]]]:
        """Return what is near in the body's frame with its cell; forget what is far, old, or where the body stands."""
        px, py, heading = pose
        c, s = math.cos(heading), math.sin(heading)
        body = self._outline
        reach = REACH + max(body.front, body.back)
        oldest = self._travel - FORGOTTEN
        near, gone = [], []
        for cell, (wx, wy, travel) in self._cells.items():
            dx, dy = wx - px, wy - py
            x, y = c * dx + s * dy, c * dy - s * dx
            if travel < oldest or abs(x) > reach or abs(y) > reach or _within(body, x, y):
                gone.append(cell)
            else:
                near.append((x, y, cell))
        for cell in gone:
            del self._cells[cell]
        return near

    def _prove_free(self, eye: _Eye, metres: float, local: list[tuple[float, float, tuple[int, int]]]) -> None:
        c, s = math.cos(eye.bearing), math.sin(eye.bearing)
        clear = metres - PROOF
        if clear <= 0.0:
            return
        for x, y, cell in local:
            dx, dy = x - eye.x, y - eye.y
            along = c * dx + s * dy
            if not 0.0 < along < clear:
                continue
            across = abs(c * dy - s * dx)
            if across < along * eye.tangent - eye.slack and along * along + across * across < clear * clear:
                self._cells.pop(cell, None)

    def _mark(self, eye: _Eye, reading: ProximityReading, metres: float, pose: Pose) -> None:
        if metres > min(REACH, eye.sensor.max_range):
            return
        # Nearer than a sensor can tell: the arc halfway is never further than the thing by more than that half.
        radius = metres / 2.0 if reading.status == "near" else metres
        px, py, heading = pose
        c, s = math.cos(heading), math.sin(heading)
        steps = max(1, math.ceil(2.0 * eye.half * radius / SPACING))
        for k in range(steps + 1):
            angle = eye.bearing - eye.half + 2.0 * eye.half * k / steps
            x, y = eye.x + radius * math.cos(angle), eye.y + radius * math.sin(angle)
            if _within(self._outline, x, y):
                continue
            wx, wy = px + c * x - s * y, py + s * x + c * y
            self._cells[math.floor(wx / CELL), math.floor(wy / CELL)] = (wx, wy, self._travel)


def _eye(sensor: Proximity) -> _Eye:
    half = min(math.radians(sensor.cone_deg) / 2.0, math.radians(89.0))
    return _Eye(
        sensor, sensor.x, sensor.y, math.radians(sensor.direction_deg), half, math.tan(half), PROOF / math.cos(half)
    )


def _within(body: Outline, x: float, y: float) -> bool:
    return -body.back < x < body.front and abs(y) < body.side
