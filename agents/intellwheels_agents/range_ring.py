"""A ring of proximity cones all round a body, and the objects that it sees.

An object is a local minimum of the ring's ranges. Its velocity is the smoothed velocity of its nearest point. The ring
cannot tell a person from a chair or a wall; a pedestrian model does not need that.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import msgspec

from intellwheels_agents.differential_drive import Odometry, wrapped
from intellwheels_agents.footprint import MovingPoint
from intellwheels_agents.portable_math import sincos
from intellwheels_agents.range_scan import SENSOR_HEIGHT, distance, outline
from intellwheels_schemas.messages import Proximity, Robot, Sensors

CONES = 48
"""Number of cones. With half as many, people who walk side by side seem to block each other."""
WIDTH = math.tau / CONES
"""Angle of a cone, rad."""
RANGE = 5.0
"""Range of the cones, m."""
SMOOTHING = 0.3
"""Time constant of an object's velocity, s."""
SIDE_MARGIN = 0.1
"""Metres by which a way out must be wider than the body, on either side."""
SAME_OBJECT = 0.3
"""Farthest that an object may move in a tick and still be recognised as the same, m."""


class NearObject(NamedTuple):
    """An object that the ring sees, in the map frame.

    Attributes:
        x, y: Its nearest point, m.
        metres: Distance to that point, m.
        bearing: Direction of that point, rad.
        velocity_x, velocity_y: Velocity of that point, m/s.
    """

    x: float
    y: float
    metres: float
    bearing: float
    velocity_x: float = 0.0
    velocity_y: float = 0.0

    def moved_from(self, other: NearObject) -> float:
        """Return how far the nearest point is from another's, m; a step to the next cone counts as 0."""
        turned = max(abs(wrapped(self.bearing - other.bearing)) - WIDTH, 0.0)
        return abs(self.metres - other.metres) + self.metres * turned


def with_ring(robot: Robot) -> Robot:
    """Return the robot with the ring of cones instead of its own proximity sensors."""
    width = 360.0 / CONES
    ring = tuple(
        Proximity(
            id=f"ring-{i}",
            x=0.0,
            y=0.0,
            z=SENSOR_HEIGHT,
            direction_deg=math.remainder(i * width, 360.0),
            cone_deg=width,
            max_range=RANGE,
        )
        for i in range(CONES)
    )
    return msgspec.structs.replace(robot, proximity=ring)


class RangeRing:
    """The objects that a body sees around it.

    Attributes:
        objects: The objects seen at the last update.
    """

    def __init__(self, robot: Robot, period: float) -> None:
        """Take a robot made by `with_ring`, and the time between two updates, s."""
        body = outline(robot)
        self._side = body.side
        self._period = period
        self._sensors = {sensor.id: (i, sensor) for i, sensor in enumerate(robot.proximity)}
        self._bearings = [math.radians(sensor.direction_deg) for sensor in robot.proximity]
        self._directions = [sincos(bearing) for bearing in self._bearings]
        # Of each cone ahead: its number, the sine and cosine of its bearing, and where the body ends in it.
        self._ahead = [
            (i, abs(s), c, _extent(body.front, body.side, bearing))
            for i, (bearing, (s, c)) in enumerate(zip(self._bearings, self._directions, strict=True))
            if abs(bearing) < math.pi / 2.0
        ]
        self._ranges = [math.inf] * len(self._bearings)
        self.objects: list[NearObject] = []

    def update(self, sensors: Sensors | None, pose: Odometry) -> None:
        """Update with the readings of a tick, taken at a pose. A cone that failed keeps its last range."""
        for reading in sensors.proximity if sensors else ():
            entry = self._sensors.get(reading.id)
            metres = None if entry is None else distance(reading, entry[1])
            if entry is not None and metres is not None:
                self._ranges[entry[0]] = metres
        known, self.objects = self.objects, []
        count = len(self._ranges)
        for i, metres in enumerate(self._ranges):
            after = self._ranges[(i + 1) % count]
            # Two cones that see one object at their common edge have equal ranges: take the first.
            if metres < self._ranges[i - 1] and metres <= after and metres <= RANGE:
                bearing = pose.heading + self._bearings[i] + (WIDTH / 2.0 if metres == after else 0.0)
                self.objects.append(self._tracked(metres, wrapped(bearing), pose, known))

    def _tracked(self, metres: float, bearing: float, pose: Odometry, known: list[NearObject]) -> NearObject:
        """Return an object, with a velocity if it is one of the known ones."""
        s, c = sincos(bearing)
        x, y = pose.x + metres * c, pose.y + metres * s
        found = NearObject(x, y, metres, bearing)
        last = min(known, key=found.moved_from, default=None)
        if last is None or found.moved_from(last) >= SAME_OBJECT:
            return found
        share = self._period / SMOOTHING
        vx = (1.0 - share) * last.velocity_x + (x - last.x) / SMOOTHING
        vy = (1.0 - share) * last.velocity_y + (y - last.y) / SMOOTHING
        return found._replace(velocity_x=vx, velocity_y=vy)

    def gap(self, turned: int = 0, beside: float = 0.0) -> float:
        """Return the free distance in front of the body, m; infinite if nothing is in the way.

        Args:
            turned: Number of cones to the left by which the body turns first.
            beside: Clearance to keep on either side, m.
        """
        gap, count = math.inf, len(self._ranges)
        for i, s, c, extent in self._ahead:
            metres = self._ranges[(i + turned) % count]
            if metres * s < self._side + beside:
                gap = min(gap, (metres - extent) * c)
        return max(gap, 0.0)

    def way_out(self, direction: float, free: float) -> float:
        """Return the direction nearest to `direction` with more than `free` m ahead; `direction` if there is none.

        Directions are in rad from straight ahead.
        """
        middle, count = round(direction / WIDTH), len(self._ranges)
        turns = sorted(range(middle - count // 2, middle + count // 2), key=lambda turn: abs(turn - middle))
        return next((wrapped(turn * WIDTH) for turn in turns if self.gap(turn, SIDE_MARGIN) > free), direction)

    def near(self, reach: float, heading: float) -> list[MovingPoint]:
        """Return the points within `reach` m, in the body frame, each with the velocity of the object nearest to it."""
        s, c = sincos(heading)
        found: list[MovingPoint] = []
        for bearing, (ray_s, ray_c), metres in zip(self._bearings, self._directions, self._ranges, strict=True):
            if metres > reach:
                continue
            in_map = bearing + heading
            owner = min(self.objects, key=lambda each: abs(wrapped(each.bearing - in_map)), default=None)
            vx, vy = (0.0, 0.0) if owner is None else (owner.velocity_x, owner.velocity_y)
            found.append((metres * ray_c, metres * ray_s, c * vx + s * vy, c * vy - s * vx))
        return found


def _extent(front: float, side: float, bearing: float) -> float:
    """Return the distance from the centre of a box to its edge in a direction, m."""
    s, c = sincos(bearing)
    s, c = abs(s), abs(c)
    return min(front / c if c > 1e-9 else math.inf, side / s if s > 1e-9 else math.inf)
