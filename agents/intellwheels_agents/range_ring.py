"""A ring of proximity cones all round a body, and the objects that it sees.

An object is a local minimum of the ring's ranges. Its velocity is the smoothed velocity of its nearest point. The ring
cannot tell a person from a chair or a wall; a pedestrian model does not need that.
"""

from __future__ import annotations

import math
from functools import lru_cache
from math import remainder
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
bearing_sincos = lru_cache(maxsize=128)(sincos)
"""The sine and cosine of a bearing: those of an object are asked for again and again in a tick."""
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
        ranges = self._ranges
        for reading in sensors.proximity if sensors else ():
            entry = self._sensors.get(reading.id)
            if entry is None:
                continue
            metres = reading.value if reading.status == "ok" else distance(reading, entry[1])
            if metres is not None:
                ranges[entry[0]] = metres
        known, self.objects = self.objects, []
        before = ranges[-1]
        for i, (metres, after) in enumerate(zip(ranges, [*ranges[1:], ranges[0]], strict=True)):
            # Two cones that see one object at their common edge have equal ranges: take the first.
            if metres < before and metres <= after and metres <= RANGE:
                bearing = pose.heading + self._bearings[i] + (WIDTH / 2.0 if metres == after else 0.0)
                self.objects.append(self._tracked(metres, wrapped(bearing), pose, known))
            before = metres

    def _tracked(self, metres: float, bearing: float, pose: Odometry, known: list[NearObject]) -> NearObject:
        """Return an object, with a velocity if it is one of the known ones."""
        s, c = bearing_sincos(bearing)
        x, y = pose.x + metres * c, pose.y + metres * s
        last, least = None, SAME_OBJECT
        # How far its nearest point is from that of a known one; a step to the next cone counts as 0.
        for other in known:
            off = abs(metres - other.metres)
            if off >= least:
                continue
            off += metres * max(abs(remainder(bearing - other.bearing, math.tau)) - WIDTH, 0.0)
            if off < least:
                last, least = other, off
        if last is None:
            return NearObject(x, y, metres, bearing)
        share = self._period / SMOOTHING
        vx = (1.0 - share) * last.velocity_x + (x - last.x) / SMOOTHING
        vy = (1.0 - share) * last.velocity_y + (y - last.y) / SMOOTHING
        return NearObject(x, y, metres, bearing, vx, vy)

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
        objects = [(each.bearing, c * each.velocity_x + s * each.velocity_y, c * each.velocity_y - s * each.velocity_x)
                   for each in self.objects]  # fmt: skip
        found: list[MovingPoint] = []
        for bearing, (ray_s, ray_c), metres in zip(self._bearings, self._directions, self._ranges, strict=True):
            if metres > reach:
                continue
            in_map = bearing + heading
            # A loop instead of `min` with a key: a walker in a crowd spends much of its time here.
            vx, vy, nearest = 0.0, 0.0, math.inf
            for at, ahead, aside in objects:
                off = abs(remainder(at - in_map, math.tau))
                if off < nearest:
                    vx, vy, nearest = ahead, aside, off
            found.append((metres * ray_c, metres * ray_s, vx, vy))
        return found


def _extent(front: float, side: float, bearing: float) -> float:
    """Return the distance from the centre of a box to its edge in a direction, m."""
    s, c = sincos(bearing)
    s, c = abs(s), abs(c)
    return min(front / c if c > 1e-9 else math.inf, side / s if s > 1e-9 else math.inf)
