"""What proximity sensors tell of the room around a body.

A reading says how near something is inside a cone, not where in it. What matters here is the
nearest place where it could stand: it blocks the way when it could be in the strip the body sweeps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from intellwheels_schemas.messages import Proximity, ProximityReading, Robot, Sensors
from intellwheels_schemas.rules import parts_of

BESIDE = math.pi / 2.0
"""Radians: straight to the side."""


@dataclass(frozen=True, slots=True)
class Outline:
    """How far a body reaches from its centre of movement, in metres, all positive."""

    front: float
    back: float
    side: float


def outline(robot: Robot) -> Outline:
    """Return the outline of a robot document's parts, whichever form it has."""
    parts = parts_of(robot)
    return Outline(
        front=max(part.x + part.length / 2.0 for part in parts),
        back=max(part.length / 2.0 - part.x for part in parts),
        side=max(abs(part.y) + part.width / 2.0 for part in parts),
    )


def distance(reading: ProximityReading, sensor: Proximity) -> float | None:
    """Return metres to what the sensor sees; infinite when there is nothing, None when it failed."""
    if reading.status == "ok":
        return reading.value
    if reading.status == "near":
        return sensor.min_range
    return math.inf if reading.status == "none" else None


class RangeScan:
    """The proximity readings of a body that drives.

    Attributes:
        left, right: Metres of room to each side, beside and ahead, infinite where nothing is seen.
        front_left, front_right: Metres of room before each front corner.
        back_left, back_right: Metres of room for the back to swing to, beside and behind.
        back: Metres of room behind.
    """

    # Beside the body, in metres: what passes nearer than this could be touched.
    MARGIN = 0.05

    def __init__(self, robot: Robot) -> None:
        """Take the sensors of `robot` that ride on it."""
        self._body = outline(robot)
        self._looking = {
            sensor.id: (sensor, math.radians(sensor.direction_deg), math.radians(sensor.cone_deg) / 2.0)
            for sensor in robot.proximity
            if sensor.mount == "body"
        }
        self.left = self.right = self.back = self._gap = math.inf
        self.front_left = self.front_right = self.back_left = self.back_right = math.inf

    def update(self, sensors: Sensors | None) -> None:
        """Take the readings of a tick. A sensor that failed, or is not there yet, is left out."""
        self._clear()
        if sensors is None:
            return
        for reading in sensors.proximity:
            entry = self._looking.get(reading.id)
            if entry is None:
                continue
            sensor, direction, half_cone = entry
            metres = distance(reading, sensor)
            if metres is None:
                continue
            bearing = math.remainder(direction, 2.0 * math.pi)
            self._sort(bearing, half_cone, metres)
            self._gap = min(self._gap, self._gap_of(sensor, bearing, half_cone, metres))

    def _clear(self) -> None:
        self.left = self.right = self.back = self._gap = math.inf
        self.front_left = self.front_right = self.back_left = self.back_right = math.inf

    def _sort(self, bearing: float, half_cone: float, metres: float) -> None:
        """Note the room a cone tells of, by where it looks."""
        off = abs(bearing)
        if off >= math.pi - half_cone:
            self.back = min(self.back, metres)
            return
        if half_cone < off < BESIDE - half_cone:
            if bearing > 0.0:
                self.front_left = min(self.front_left, metres)
            else:
                self.front_right = min(self.front_right, metres)
        # A quarter turn to the side is both: the side ahead and the side the back swings to.
        if half_cone < off <= BESIDE + half_cone:
            if bearing > 0.0:
                self.left = min(self.left, metres)
            else:
                self.right = min(self.right, metres)
        if off >= BESIDE - half_cone:
            if bearing > 0.0:
                self.back_left = min(self.back_left, metres)
            else:
                self.back_right = min(self.back_right, metres)

    @property
    def gap(self) -> float:
        """Metres from the body's front to the nearest thing that could be in its way, infinite if none."""
        return self._gap

    def _gap_of(self, sensor: Proximity, direction: float, half_cone: float, metres: float) -> float:
        if math.isinf(metres):
            return math.inf
        # The ray of the cone nearest to straight ahead is where it would be most in the way.
        bearing = math.copysign(max(abs(direction) - half_cone, 0.0), direction)
        # A cone wholly beside the body tells nothing of what is ahead.
        if abs(bearing) > math.radians(60.0):
            return math.inf
        across = sensor.y + metres * math.sin(bearing)
        if abs(across) > self._body.side + self.MARGIN:
            return math.inf
        return max(0.0, sensor.x + metres * math.cos(bearing) - self._body.front)
