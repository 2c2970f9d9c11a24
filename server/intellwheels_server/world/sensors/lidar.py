"""Lidars: ranges by angle. `kernels.lidar_rays` computes them and their errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from intellwheels_schemas.messages import Lidar, LidarReading, Map, Status
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.lidar_rays import scan
from intellwheels_server.world.sensors.angles import unit_vector
from intellwheels_server.world.sensors.kind import READING_BYTES, Fitted, Kind, View

# The status of a ray, at the index of its negated code.
RAY_BYTES = 32
"""Largest number of bytes of a range and its status."""

_STATUS: tuple[Status, ...] = ("ok", "none", "near", "fault")


def angles(declaration: Lidar) -> tuple[float, float]:
    """Return the angle of the first ray in the body frame and the step from ray to ray, degrees.

    The first and the last ray are the edges of the field of view. In a full circle they are one step apart. A single
    ray is in the middle.
    """
    gaps = declaration.rays if declaration.fov_deg >= 360.0 else declaration.rays - 1
    if declaration.rays == 1:
        return declaration.direction_deg, 0.0
    start = declaration.direction_deg - 0.5 * declaration.fov_deg
    return (start + 360.0 if start < -360.0 else start), declaration.fov_deg / gaps


@dataclass(frozen=True)
class LidarBlock:
    """All lidars, as `scan` takes them."""

    scanners: Floats
    reels: Ints
    directions: Floats
    schedule: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        scan(
            tick,
            view.period,
            view.numbers,
            view.parts,
            view.part_start,
            *view.walls,
            self.scanners,
            self.reels,
            self.directions,
            self.schedule,
            samples,
        )


class LidarKind(Kind):
    """The kind that serves `Lidar`."""

    declaration = Lidar

    def examples(self, _floor: Map, /) -> tuple[Lidar, ...]:
        """Return a lidar of a few rays."""
        return (Lidar(id=self.field, x=0.5, y=0.0, z=0.4, direction_deg=0.0, fov_deg=180.0, rays=9, max_range=9.0),)

    def width(self, declaration: Lidar, /) -> int:
        """Return the numbers in a sample: its time, and one for each ray."""
        return 1 + declaration.rays

    def rays(self, declaration: Lidar, /) -> float:
        """Return its rays."""
        return float(declaration.rays)

    def reading_bytes(self, declaration: Lidar, /) -> int:
        """Return a bound: each ray has a range and a status."""
        return READING_BYTES + RAY_BYTES * declaration.rays

    def compile(self, fitted: Sequence[Fitted], schedule: Ints, /) -> LidarBlock:
        """Return the block."""
        scanners: list[tuple[float, ...]] = []
        reels: list[tuple[int, int, int]] = []
        directions: list[Floats] = []
        end = 0
        for sensor in fitted:
            one: Lidar = sensor.declaration
            start, step = angles(one)
            directions.append(_directions(start, step, one.rays))
            begin, end = end, end + one.rays
            reels.append((int(one.mount == "start"), begin, end))
            least_cos, _ = unit_vector(one.incidence_deg)
            at = (sensor.start.x, sensor.start.y, sensor.start.heading, one.x, one.y, one.z)
            errors = (one.noise, one.noise_share, least_cos, one.dropout)
            scanners.append((*at, one.min_range, one.max_range, *errors))
        return LidarBlock(
            scanners=np.array(scanners, dtype=np.float64),
            reels=np.array(reels, dtype=np.int64),
            directions=np.concatenate(directions),
            schedule=schedule,
        )

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> LidarReading:
        """Return the ranges, m, and the time of the scan; a lidar sends all its rays at once."""
        start, step = angles(sensor.declaration)
        return LidarReading(
            id=sensor.declaration.id,
            tick=tick,
            stamp=sample[0],
            start_deg=start,
            step_deg=step,
            ranges=tuple([way if way >= 0.0 else None for way in sample[1:]]),
            statuses=tuple(["ok" if way >= 0.0 else _STATUS[int(-way)] for way in sample[1:]]),
        )


@lru_cache(maxsize=64)  # most scanners are like another one
def _directions(start: float, step: float, rays: int) -> Floats:
    """Return the unit vectors of rays, float64[rays, 2], which nobody may change.

    Args:
        start: Direction of the first ray, degrees.
        step: From ray to ray, degrees.
        rays: How many.
    """
    return np.array([unit_vector(start + ray * step) for ray in range(rays)], dtype=np.float64)
