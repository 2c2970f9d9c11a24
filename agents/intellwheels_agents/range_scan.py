"""The clearances around a body, from its proximity sensors.

A reading says how near an obstacle is inside a cone, but not where in the cone. What counts here is the nearest place
where it could be: it blocks the way if it could be in the strip that the body sweeps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from intellwheels_agents.portable_math import cos, sin
from intellwheels_schemas.messages import Proximity, ProximityReading, Robot, Sensors
from intellwheels_schemas.rules import parts_of

BESIDE = math.pi / 2.0
"""Straight to the side, rad."""
SENSOR_HEIGHT = 0.4
"""Height above the floor of added proximity sensors, m: legs, footrests and bumpers are there."""


@dataclass(frozen=True, slots=True)
class Outline:
    """How far a body extends from its centre of movement, m, all positive."""

    front: float
    back: float
    side: float


def outline(robot: Robot) -> Outline:
    """Return the outline of a robot document, whether it has parts or one box."""
    parts = parts_of(robot)
    return Outline(
        front=max(part.x + part.length / 2.0 for part in parts),
        back=max(part.length / 2.0 - part.x for part in parts),
        side=max(abs(part.y) + part.width / 2.0 for part in parts),
    )


def distance(reading: ProximityReading, sensor: Proximity) -> float | None:
    """Return the range of a reading in m: infinite if nothing is in range, None if the sensor failed."""
    if reading.status == "ok":
        return reading.value
    if reading.status == "near":
        return sensor.min_range
    return math.inf if reading.status == "none" else None


class RangeScan:
    """The clearances of a body, from the readings of one tick; m, infinite where nothing is seen.

    Attributes:
        left, right: To each side, beside and ahead.
        front_left, front_right: In front of each front corner.
        back_left, back_right: Where the back swings in a turn, beside and behind.
        back: Behind.
    """

    # Added to each side of the body's strip, in m: an obstacle that passes nearer than this could be touched.
    MARGIN = 0.05

    def __init__(self, robot: Robot) -> None:
        """Take the sensors of `robot` that move with it."""
        self._body = outline(robot)
        self._looking = {
            sensor.id: (sensor, math.radians(sensor.direction_deg), math.radians(sensor.cone_deg) / 2.0)
            for sensor in robot.proximity
            if sensor.mount == "body"
        }
        self.left = self.right = self.back = self._gap = math.inf
        self.front_left = self.front_right = self.back_left = self.back_right = math.inf

    def update(self, sensors: Sensors | None) -> None:
        """Update with the readings of a tick. A sensor that failed, or has not measured yet, is ignored."""
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
        """Store a range in the clearances that belong to the cone's direction."""
        off = abs(bearing)
        if off >= math.pi - half_cone:
            self.back = min(self.back, metres)
            return
        if half_cone < off < BESIDE - half_cone:
            if bearing > 0.0:
                self.front_left = min(self.front_left, metres)
            else:
                self.front_right = min(self.front_right, metres)
        # A cone straight to the side counts twice: as the side, and as where the back swings.
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
        """Distance from the body's front to the nearest obstacle that could be in its way, m; infinite if none."""
        return self._gap

    def _gap_of(self, sensor: Proximity, direction: float, half_cone: float, metres: float) -> float:
        if math.isinf(metres):
            return math.inf
        # Assume the obstacle on the cone's ray nearest to straight ahead, where it would be most in the way.
        bearing = math.copysign(max(abs(direction) - half_cone, 0.0), direction)
        # A cone that is entirely beside the body says nothing about what is ahead.
        if abs(bearing) > math.radians(60.0):
            return math.inf
        across = sensor.y + metres * sin(bearing)
        if abs(across) > self._body.side + self.MARGIN:
            return math.inf
        return max(0.0, sensor.x + metres * cos(bearing) - self._body.front)
