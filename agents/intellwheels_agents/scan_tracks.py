"""What a pedestrian sees: the points of a lidar all round, each with the velocity of the object that it belongs to.

An object is a run of neighbouring points. An alpha-beta filter tracks its centre. The lidar cannot tell a person from a
chair. An object that is longer than a person or chair counts as a wall and has no velocity, because its visible part
changes while the pedestrian walks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import msgspec

from intellwheels_agents.differential_drive import Odometry
from intellwheels_agents.footprint import MovingPoint
from intellwheels_agents.portable_math import hypot, sincos
from intellwheels_agents.range_scan import SENSOR_HEIGHT
from intellwheels_schemas.messages import Lidar, Robot, Sensors

LIDAR = "view"
"""Id of the lidar."""
RAYS = 180
"""Rays of the lidar, 2 degrees apart (chosen): a leg of 0.05 m is seen from 1.4 m on."""
RANGE = 6.0
"""Range of the lidar, m (chosen)."""
JUMP = 0.25
"""Difference of neighbouring ranges that separates two objects, m (chosen)."""
LONGEST = 1.6
"""Extent above which an object counts as a wall, m: two people abreast, or a chair, are shorter (chosen)."""
SAME_OBJECT = 0.45
"""Farthest from its expected place at which an object is recognised, m (chosen)."""
ALPHA, BETA = 0.5, 0.12
"""Gains of the alpha-beta filter at `TICK`, chosen: the velocity settles within 0.3 s."""
TICK = 0.05
"""The period for which the gains are given, s."""
SHORTEST_CHAIR = 0.55
"""Extent above which an object that moves may be a chair, m: a person who comes straight on is 0.5 m wide."""
KNOWN = 3
"""Updates after which the velocity of an object counts (chosen)."""
SPACING = 0.1
"""Least distance of neighbouring points that are kept, m, and less within 1 m in proportion (chosen)."""


class Track(NamedTuple):
    """An object that is followed: its centre (m) and velocity (m/s) in the map frame, and its number of updates."""

    x: float
    y: float
    velocity_x: float = 0.0
    velocity_y: float = 0.0
    updates: int = 0


def with_view(robot: Robot) -> Robot:
    """Return the robot with the lidar instead of its own proximity sensors."""
    lidar = Lidar(id=LIDAR, x=0.0, y=0.0, z=SENSOR_HEIGHT, direction_deg=0.0, fov_deg=360.0, rays=RAYS, max_range=RANGE)
    others = tuple(one for one in robot.lidar if one.id != LIDAR)
    return msgspec.structs.replace(robot, proximity=(), lidar=(*others, lidar))


class ScanTracks:
    """The points around a body, with their velocities.

    Attributes:
        points: x and y (m) from the body's centre and the velocity (m/s) of each point, along the axes of the map.
        large: Those of them that belong to moving objects longer than a person, which may be chairs.
    """

    def __init__(self, period: float) -> None:
        """Take the time between two updates, s."""
        self._period = period
        # The same time constants at any period.
        self._alpha = 1.0 - (1.0 - ALPHA) ** (period / TICK)
        self._beta = min(BETA * period / TICK, self._alpha)
        self._rays = [sincos(math.radians(-180.0 + k * 360.0 / RAYS)) for k in range(RAYS)]
        self._tracks: list[Track] = []
        self.points: list[MovingPoint] = []
        self.large: list[MovingPoint] = []

    def count(self, pose: Odometry, reach: float) -> int:
        """Return the number of objects, apart from walls, whose centres are within a reach, m."""
        return sum(hypot(one.x - pose.x, one.y - pose.y) < reach for one in self._tracks)

    def update(self, sensors: Sensors | None, pose: Odometry) -> None:
        """Update with the scan of a tick, taken at a pose; without a scan everything stays as it was."""
        for scan in sensors.lidar if sensors else ():
            if scan.id == LIDAR and len(scan.ranges) == RAYS:
                self._take(scan.ranges, pose)

    def _take(self, ranges: tuple[float | None, ...], pose: Odometry) -> None:
        known, self._tracks = self._tracks, []
        points: list[MovingPoint] = []
        self.large = []
        for run in self._objects(ranges, pose.heading):
            extent, velocity_x, velocity_y = self._velocity(run, pose, known)
            before = len(points)
            kept_x = kept_y = math.inf
            last = run[-1]
            for point in run:
                x, y = point
                spacing = SPACING * min(abs(x) + abs(y), 1.0)
                if abs(x - kept_x) + abs(y - kept_y) >= spacing or point is last:
                    points.append((x, y, velocity_x, velocity_y))
                    kept_x, kept_y = x, y
            # The edges of an object may be up to a ray farther out than its outer points.
            between = math.tau / RAYS * hypot(*run[0])
            if extent + between > SHORTEST_CHAIR and (velocity_x or velocity_y):
                self.large += points[before:]
        self.points = points

    def _objects(self, ranges: tuple[float | None, ...], heading: float) -> list[list[tuple[float, float]]]:
        """Return the runs of neighbouring points, from the body's centre along the axes of the map."""
        s, c = sincos(heading)
        runs: list[list[tuple[float, float]]] = []
        run: list[tuple[float, float]] = []
        last = math.inf
        for metres, (ray_s, ray_c) in zip(ranges, self._rays, strict=True):
            if metres is None:
                last = math.inf
                continue
            if not abs(metres - last) < JUMP:
                run = []
                runs.append(run)
            run.append((metres * (c * ray_c - s * ray_s), metres * (s * ray_c + c * ray_s)))
            last = metres
        first = ranges[0]
        if len(runs) > 1 and first is not None and abs(first - last) < JUMP:
            runs[0] = runs.pop() + runs[0]
        return runs

    def _velocity(
        self, run: list[tuple[float, float]], pose: Odometry, known: list[Track]
    ) -> tuple[float, float, float]:
        """Return the extent (m) and velocity (m/s) of an object, and follow it."""
        xs, ys = [x for x, _ in run], [y for _, y in run]
        low_x, high_x, low_y, high_y = min(xs), max(xs), min(ys), max(ys)
        extent = hypot(high_x - low_x, high_y - low_y)
        if extent > LONGEST:
            return extent, 0.0, 0.0
        x, y = pose.x + (low_x + high_x) / 2.0, pose.y + (low_y + high_y) / 2.0
        period, nearest, track = self._period, SAME_OBJECT * SAME_OBJECT, None
        for one in known:
            off_x, off_y = x - one.x - one.velocity_x * period, y - one.y - one.velocity_y * period
            square = off_x * off_x + off_y * off_y
            if square < nearest:
                nearest, track, left_x, left_y = square, one, off_x, off_y
        if track is None:
            self._tracks.append(Track(x, y))
            return extent, 0.0, 0.0
        gain = self._beta / period
        velocity_x, velocity_y = track.velocity_x + gain * left_x, track.velocity_y + gain * left_y
        rest = 1.0 - self._alpha
        self._tracks.append(Track(x - rest * left_x, y - rest * left_y, velocity_x, velocity_y, track.updates + 1))
        return (extent, velocity_x, velocity_y) if track.updates >= KNOWN else (extent, 0.0, 0.0)
