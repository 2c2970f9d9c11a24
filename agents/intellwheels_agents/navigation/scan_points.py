"""What the lidars see, as points around the body."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from intellwheels_agents.navigation.array_angles import Floats, sines
from intellwheels_agents.portable_math import sincos
from intellwheels_schemas.messages import Lidar, LidarReading, Measures, Robot

THIN: Final = 0.05
"""Size of the cells of which each keeps one point, m."""

Pose = tuple[float, float, float]


class ScanPoints:
    """The points that lidars on the body see."""

    def __init__(self, robot: Robot) -> None:
        """Take the lidars that move with the body."""
        self._lidars: dict[str, Lidar] = {lidar.id: lidar for lidar in robot.lidar if lidar.mount == "body"}
        self._rays: dict[tuple[str, int], tuple[Floats, Floats]] = {}

    def update(self, measures: Measures) -> list[tuple[int, Floats]]:
        """Return for each scan its tick and its points (x, y) in the body's frame at that tick, m, by angle."""
        found = []
        for reading in measures.sensors.lidar if measures.sensors else ():
            lidar = self._lidars.get(reading.id)
            if lidar is not None and reading.ranges:
                found.append((measures.tick if reading.tick is None else reading.tick, self._points(lidar, reading)))
        return found

    def _points(self, lidar: Lidar, reading: LidarReading) -> Floats:
        count = len(reading.ranges)
        rays = self._rays.get((reading.id, count))
        if rays is None:
            degrees = reading.start_deg + reading.step_deg * np.arange(count, dtype=np.float64)
            s, c = sines(degrees * (math.pi / 180.0))
            rays = self._rays[reading.id, count] = c, s
        near = lidar.min_range / 2.0
        if reading.statuses:
            values = [
                metres if metres is not None else near if status == "near" else -1.0
                for metres, status in zip(reading.ranges, reading.statuses, strict=False)
            ]
        else:
            values = [-1.0 if metres is None else metres for metres in reading.ranges]
        metres = np.array(values)
        seen = metres >= 0.0
        metres = metres[seen]
        return np.stack([lidar.x + metres * rays[0][seen], lidar.y + metres * rays[1][seen]], axis=1)


def moved(points: Floats, then: Pose, now: Pose) -> Floats:
    """Return points of the body's frame at a pose in its frame at another pose."""
    return into_body(into_map(points, then), now)


def into_map(points: Floats, pose: Pose) -> Floats:
    """Return points of the body's frame in the map's."""
    s, c = sincos(pose[2])
    return np.stack(
        [pose[0] + c * points[:, 0] - s * points[:, 1], pose[1] + s * points[:, 0] + c * points[:, 1]], axis=1
    )


def into_body(points: Floats, pose: Pose) -> Floats:
    """Return points of the map in the body's frame."""
    s, c = sincos(pose[2])
    dx, dy = points[:, 0] - pose[0], points[:, 1] - pose[1]
    return np.stack([c * dx + s * dy, c * dy - s * dx], axis=1)


def thinned(points: Floats, size: float = THIN) -> Floats:
    """Return one of the points of each cell: the first."""
    if not points.shape[0]:
        return points
    cells = np.floor(points[:, :2] / size).astype(np.int64)
    _, first = np.unique(cells[:, 0] * 100_003 + cells[:, 1], return_index=True)
    return np.asarray(points[np.sort(first)])
