"""A ring of proximity cones all round a body, and the things that stand or move in it.

A thing is where the ring is nearer than on either side; how it moves is how its nearest point moved, smoothed. The
ring cannot tell a person from a chair or a wall, and who walks needs no more.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import msgspec

from intellwheels_agents.differential_drive import Odometry, wrapped
from intellwheels_agents.footprint import Moving
from intellwheels_agents.range_scan import distance, outline
from intellwheels_schemas.messages import Proximity, Robot, Sensors

CONES = 48
"""Cones all round. With half as many, people beside each other seem to stand in each other's way."""
WIDTH = math.tau / CONES
SIGHT = 5.0
"""Metres it looks."""
EYE = 0.4
"""Metres over the floor it looks at: legs, footrests, bumpers."""
TRACKING = 0.3
"""Seconds over which the motion of a thing is smoothed."""
BESIDE = 0.1
"""Metres a way out is wider than the body on either side."""
SAME = 0.3
"""Metres by which a thing may seem to move in a cycle."""


class Thing(NamedTuple):
    """Somebody or something near, in the map's frame.

    Attributes:
        x, y: Its nearest point, m.
        metres: To that point.
        bearing: Of that point, rad.
        velocity_x, velocity_y: Of that point, m/s.
    """

    x: float
    y: float
    metres: float
    bearing: float
    velocity_x: float = 0.0
    velocity_y: float = 0.0

    def off(self, other: Thing) -> float:
        """Return how far the nearest point moved, m; a point on the next cone moved by nothing."""
        turned = max(abs(wrapped(self.bearing - other.bearing)) - WIDTH, 0.0)
        return abs(self.metres - other.metres) + self.metres * turned


def with_ring(robot: Robot) -> Robot:
    """Return the robot with the ring of cones in place of its own proximity sensors."""
    width = 360.0 / CONES
    ring = tuple(
        Proximity(
            id=f"ring-{i}",
            x=0.0,
            y=0.0,
            z=EYE,
            direction_deg=math.remainder(i * width, 360.0),
            cone_deg=width,
            max_range=SIGHT,
        )
        for i in range(CONES)
    )
    return msgspec.structs.replace(robot, proximity=ring)


class RangeRing:
    """What a body sees around it.

    Attributes:
        things: In it at the last update, none nearer than its neighbours left out.
    """

    def __init__(self, robot: Robot, period: float) -> None:
        """Take a robot `with_ring`, and the seconds between two updates."""
        body = outline(robot)
        self._side = body.side
        self._period = period
        self._sensors = {sensor.id: (i, sensor) for i, sensor in enumerate(robot.proximity)}
        self._bearings = [math.radians(sensor.direction_deg) for sensor in robot.proximity]
        self._extents = [_extent(body.front, body.side, bearing) for bearing in self._bearings]
        self._ranges = [math.inf] * len(self._bearings)
        self.things: list[Thing] = []

    def update(self, sensors: Sensors | None, pose: Odometry) -> None:
        """Take the readings of a tick, seen from a pose. A cone that failed keeps what it saw."""
        for reading in sensors.proximity if sensors else ():
            entry = self._sensors.get(reading.id)
            metres = None if entry is None else distance(reading, entry[1])
            if entry is not None and metres is not None:
                self._ranges[entry[0]] = metres
        known, self.things = self.things, []
        count = len(self._ranges)
        for i, metres in enumerate(self._ranges):
            after = self._ranges[(i + 1) % count]
            # Of two cones that see one thing at their common edge the first is it.
            if metres < self._ranges[i - 1] and metres <= after and metres <= SIGHT:
                bearing = pose.heading + self._bearings[i] + (WIDTH / 2.0 if metres == after else 0.0)
                self.things.append(self._followed(metres, wrapped(bearing), pose, known))

    def _followed(self, metres: float, bearing: float, pose: Odometry, known: list[Thing]) -> Thing:
        """Return a thing with the velocity that follows from the one it was."""
        x, y = pose.x + metres * math.cos(bearing), pose.y + metres * math.sin(bearing)
        thing = Thing(x, y, metres, bearing)
        last = min(known, key=thing.off, default=None)
        if last is None or thing.off(last) >= SAME:
            return thing
        share = self._period / TRACKING
        vx = (1.0 - share) * last.velocity_x + (x - last.x) / TRACKING
        vy = (1.0 - share) * last.velocity_y + (y - last.y) / TRACKING
        return thing._replace(velocity_x=vx, velocity_y=vy)

    def gap(self, turned: int = 0, beside: float = 0.0) -> float:
        """Return metres from the body to what it would walk into; infinite if there is nothing.

        Args:
            turned: Cones to the left of straight on that it would turn to first.
            beside: Metres it keeps on either side.
        """
        gap, count = math.inf, len(self._ranges)
        for i, (bearing, extent) in enumerate(zip(self._bearings, self._extents, strict=True)):
            metres = self._ranges[(i + turned) % count]
            if abs(bearing) < math.pi / 2.0 and metres * abs(math.sin(bearing)) < self._side + beside:
                gap = min(gap, (metres - extent) * math.cos(bearing))
        return max(gap, 0.0)

    def way_out(self, direction: float, room: float) -> float:
        """Return the direction nearest to one, rad from straight on, in which there are so many metres of room."""
        middle, count = round(direction / WIDTH), len(self._ranges)
        turns = sorted(range(middle - count // 2, middle + count // 2), key=lambda turn: abs(turn - middle))
        return next((wrapped(turn * WIDTH) for turn in turns if self.gap(turn, BESIDE) > room), direction)

    def near(self, reach: float, heading: float) -> list[Moving]:
        """Return the points within so many metres, in the body's frame, each with the velocity of its thing."""
        c, s = math.cos(heading), math.sin(heading)
        found: list[Moving] = []
        for bearing, metres in zip(self._bearings, self._ranges, strict=True):
            if metres > reach:
                continue
            in_map = bearing + heading
            thing = min(self.things, key=lambda thing: abs(wrapped(thing.bearing - in_map)), default=None)
            vx, vy = (0.0, 0.0) if thing is None else (thing.velocity_x, thing.velocity_y)
            found.append((metres * math.cos(bearing), metres * math.sin(bearing), c * vx + s * vy, c * vy - s * vx))
        return found


def _extent(front: float, side: float, bearing: float) -> float:
    """Return metres from the middle of a box to its edge in a direction."""
    c, s = abs(math.cos(bearing)), abs(math.sin(bearing))
    return min(front / c if c > 1e-9 else math.inf, side / s if s > 1e-9 else math.inf)
