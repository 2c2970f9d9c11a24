"""Ground sensors: the zone under a point of the body. Of zones that overlap, the first of the map counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from intellwheels_schemas.messages import Ground, GroundReading, Map
from intellwheels_server.world.kernels import rows
from intellwheels_server.world.kernels.arrays import Floats, Ints
from intellwheels_server.world.kernels.elementary import sincos
from intellwheels_server.world.kernels.sample_schedule import BODY, due_slot
from intellwheels_server.world.sensors.kind import Fitted, Kind, View, Written


@njit(cache=True, error_model="numpy")
def _zone_at(corners: Floats, starts: Ints, x: float, y: float) -> int:
    """Return the first zone that holds a point, or -1: a line to the right crosses its edge an odd number of times.

    An edge includes its lower end and not its upper one, so exactly one of two adjacent zones contains their border.
    """
    for zone in range(starts.shape[0] - 1):
        inside = False
        before = starts[zone + 1] - 1
        for corner in range(starts[zone], starts[zone + 1]):
            low, high = corners[before, 1], corners[corner, 1]
            if (low <= y) != (high <= y):
                at = corners[before, 0] + (y - low) / (high - low) * (corners[corner, 0] - corners[before, 0])
                if x < at:
                    inside = not inside
            before = corner
        if inside:
            return zone
    return -1


@njit(cache=True, error_model="numpy")
def _take(
    tick: int, numbers: Floats, points: Floats, corners: Floats, starts: Ints, schedule: Ints, samples: Floats
) -> None:
    for sensor in range(schedule.shape[0]):
        slot = due_slot(schedule, sensor, tick, 1)
        if slot < 0:
            continue
        body = schedule[sensor, BODY]
        s, c = sincos(numbers[rows.HEADING, body])
        x = numbers[rows.X, body] + (c * points[sensor, 0] - s * points[sensor, 1])
        y = numbers[rows.Y, body] + (s * points[sensor, 0] + c * points[sensor, 1])
        samples[slot] = _zone_at(corners, starts, x, y)


@dataclass(frozen=True)
class GroundBlock:
    """All ground sensors, and the zones: the corners of all, the first corner of each, and the end."""

    points: Floats
    corners: Floats
    starts: Ints
    schedule: Ints

    def take(self, tick: int, view: View, samples: Floats) -> None:
        """Store the samples that are due at a tick."""
        _take(tick, view.numbers, self.points, self.corners, self.starts, self.schedule, samples)


class GroundKind(Kind):
    """The kind that serves `Ground`."""

    declaration = Ground

    def compile(self, fitted: Sequence[Fitted], schedule: Ints, /) -> GroundBlock:
        """Return the block."""
        floor: Map = fitted[0].floor
        corners = [(corner.x, corner.y) for zone in floor.zone for corner in zone.corner]
        return GroundBlock(
            points=np.array([(one.declaration.x, one.declaration.y) for one in fitted], dtype=np.float64),
            corners=np.array(corners, dtype=np.float64).reshape(-1, 2),
            starts=np.cumsum([0, *(len(zone.corner) for zone in floor.zone)], dtype=np.int64),
            schedule=schedule,
        )

    def written(self, sensor: Fitted, /) -> Written:
        """Return the zone as the code."""
        return Written(codes=1 + len(sensor.floor.zone), lowest=-1)

    def reading(self, sensor: Fitted, tick: int | None, sample: Sequence[float]) -> GroundReading:
        """Return the zone's name, or none."""
        index = int(sample[0])
        name = None if index < 0 else sensor.floor.zone[index].name
        return GroundReading(id=sensor.declaration.id, tick=tick, zone=name)
