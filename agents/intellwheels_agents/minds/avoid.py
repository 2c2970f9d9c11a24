"""Wanders about and touches nothing at the height of its sensors.

    speed    speed with nothing near, m/s; less if the sensors do not see as far as it needs to stop (default 0.5)
    clear    distance ahead at which it begins to slow down, m (default 1.5)
    stop     distance ahead at which it turns in place, m; less than clear (default 0.5)

The cones of most included chairs do not cover the bearings from 15 to 30 degrees on either side, and do not tell where
in a cone an object is. So the mind adds a 360-degree lidar at the height of the robot's own sensors, and uses only this
lidar. If another process provides the body, and the body has no such lidar, the mind uses its proximity sensors. It is
then blind between their cones, and treats an obstacle as if it could be anywhere on the arc at the measured distance.

It never gives a command after which it could not stop in time. It drives ahead and bends away from what is near. In
front of an obstacle it turns in place to the side with more room, and keeps to that side until the way ahead is free.
If it cannot turn, it backs out. If it cannot do that either, it tries the other side, and then creeps ahead.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from typing import Final

import msgspec

from intellwheels_agents.differential_drive import Odometry
from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.path_follower import TURN_RATE
from intellwheels_agents.portable_math import dist, sincos
from intellwheels_agents.pure_pursuit import Point
from intellwheels_agents.range_scan import distance, outline
from intellwheels_agents.stopping_sweep import MARGIN, StoppingSweep
from intellwheels_schemas.messages import Actions, Lidar, LidarReading, Measures, Proximity, ProximityReading, Robot

RAYS: Final = 240
"""Rays of the lidar, 1.5 degrees apart: it sees a table leg of 0.05 m from 1.9 m on."""
LIDAR: Final = "around"
"""Id of the lidar."""
HEIGHT, RANGE = 0.4, 4.0
"""Height and range of the lidar of a robot without proximity sensors, m: those of the included chairs."""
POINT_GAP: Final = math.radians(3.5)
"""Largest angle between two points on the arc of a reading, rad: 0.03 m from any place of it at 1 m."""
SHARES: Final = (1.0, 0.6, 0.35, 0.2, 0.1, 0.05)
"""Shares of a speed that are tried, the largest first."""
BENDS: Final = (0.0, 0.3, -0.3, 0.6, -0.6)
"""Turn rates that are tried beside the wanted one, rad/s."""
LEAST_TURN: Final = 0.5
"""Angle by which it turns at least, once it turns, rad."""
WAY_BACK: Final = 0.4
"""Distance that it backs out, m."""
ORDER: Final = {
    "ahead": ("ahead", "turn", "back", "other", "creep"),
    "turn": ("turn", "back", "creep", "other"),
    "back": ("back", "creep", "turn", "other"),
    "creep": ("creep", "turn", "back", "other"),
}
"""What it tries in each mode, in this order; `other` is to turn to the other side."""
SHUNNED: Final = 2.0
"""Time for which it does not do again what led into something that no sensor sees, s."""
PATIENCE: Final = 5.0
"""Time without moving 0.1 m or turning 0.3 rad after which it keeps less clear until it has done four times that, s."""
SQUEEZED: Final = 0.02
"""The margin that it then keeps, m. A corner between two rays is up to 0.013 m nearer than they say, at 1 m."""
_POSES_KEPT: Final = 40

Pose = tuple[float, float, float]


def equip(robot: Robot, _options: Options) -> Robot:
    """Return the robot with the lidar, as high, as far and as late as its own sensors; as it is if it has one."""
    if any(one.fov_deg >= 360.0 for one in robot.lidar):
        return robot
    own = next((one for one in robot.proximity if one.mount == "body" and one.source == "simulated"), None)
    lidar = Lidar(
        id=LIDAR, x=0.0, y=0.0, z=own.z if own else HEIGHT, direction_deg=0.0, fov_deg=360.0, rays=RAYS,
        max_range=own.max_range if own else RANGE, every=own.every if own else 1, latency=own.latency if own else 0,
    )  # fmt: skip
    return msgspec.structs.replace(robot, lidar=(*robot.lidar, lidar))


class Mind:
    """Decides from the latest reading of each sensor."""

    def __init__(self, context: Context) -> None:
        options, robot = context.options, context.robot
        self._speed = options.number("speed", 0.5, 0.0, 5.0)
        self._clear = options.number("clear", 1.5, 0.1, 20.0)
        self._stop = options.number("stop", 0.5, 0.05, 20.0)
        if self._stop >= self._clear:
            raise OptionError(f"option stop: expected less than clear ({self._clear:g}), got {self._stop:g}")
        self._sweep = StoppingSweep(robot, context.parameters.period)
        self._body = outline(robot)
        self._lidar = next((one for one in robot.lidar if one.fov_deg >= 360.0 and one.mount == "body"), None)
        self._rays = [] if self._lidar is None else _rays(self._lidar)
        cones = [one for one in robot.proximity if one.mount == "body"] if self._lidar is None else []
        self._arcs = {one.id: (one, _directions(one)) for one in cones}
        # What it sees must suffice to stop.
        seen = min((one.max_range for one in (self._lidar, *cones) if one is not None), default=math.inf)
        while self._speed > 0.0 and self._sweep.needed(self._speed) > max(seen - self._sweep.radius, 0.0):
            self._speed = 0.9 * self._speed if self._speed > 0.05 else 0.0
        self._watched = max(self._sweep.needed(self._speed), self._sweep.needed(TURN_RATE * self._sweep.radius))
        # By sensor, where things may be on the map.
        self._near: dict[str, list[Point]] = {}
        self._pose = Odometry(robot, context.position, compass_share=0.0)
        self._poses: deque[tuple[int, Pose]] = deque(maxlen=_POSES_KEPT)
        self._mode = "ahead"
        self._side = 1.0
        self._turned = self._backed = 0.0
        # When and where it last was elsewhere.
        self._anchor = (0.0, (context.position.x, context.position.y, context.position.heading))
        # Until when it does not do again what led into something that no sensor sees, by mode and side, s.
        self._shunned: dict[tuple[str, float], float] = {}

    def decide(self, measures: Measures) -> Actions:
        """Return the powers for the present readings."""
        points = self._perceive(measures)
        if measures.collision:
            # Something that no sensor sees is in the way: above or below their height.
            self._shunned[self._mode, self._side] = measures.time + SHUNNED
            if self._mode in ("ahead", "creep"):
                self._begin("back")
        self._shunned = {way: until for way, until in self._shunned.items() if until > measures.time}
        left, right = self._sweep.drive(*self._motion(points))
        return Actions(left_motor=left, right_motor=right, mode="autonomous")

    def _perceive(self, measures: Measures) -> list[Point]:
        """Return where things may be, in the present frame of the body, m."""
        sensors = measures.sensors
        before = self._pose.x, self._pose.y, self._pose.heading
        self._pose.update(sensors)
        now = self._pose.x, self._pose.y, self._pose.heading
        self._poses.append((measures.tick, now))
        self._turned += abs(math.remainder(now[2] - before[2], math.tau))
        self._backed += dist(now[:2], before[:2])
        self._sweep.measure(sensors.encoders[0] if sensors and sensors.encoders else None)
        reach = max(self._clear, self._watched) + self._sweep.radius
        for reading in sensors.proximity if sensors else ():
            entry = self._arcs.get(reading.id)
            metres = None if entry is None else distance(reading, entry[0])
            if entry is None or metres is None:
                continue
            sensor, directions = entry
            seen = directions if metres <= min(reach, sensor.max_range) else []
            self._store(reading, [(sensor.x + metres * c, sensor.y + metres * s) for s, c in seen], now)
        lidar = self._lidar
        for scan in sensors.lidar if sensors and lidar else ():
            if lidar is not None and scan.id == lidar.id and len(scan.ranges) == len(self._rays):
                # A failed ray counts as free: it is seen again in the next scan, beside its neighbours.
                rays = zip(scan.ranges, self._rays, strict=True)
                spots = [(lidar.x + r * c, lidar.y + r * s) for r, (s, c) in rays if r is not None and r <= reach]
                self._store(scan, spots, now)
        points = [point for point in self._in_frame(now) if not self._sweep.contains(*point)]
        since, (x, y, heading) = self._anchor
        squeezes = measures.time - since >= PATIENCE
        moved, turned = dist(now[:2], (x, y)), abs(math.remainder(now[2] - heading, math.tau))
        if max(moved / 0.1, turned / 0.3) > (4.0 if squeezes else 1.0):
            squeezes, self._anchor = False, (measures.time, now)
        margin = SQUEEZED if squeezes else MARGIN
        self._sweep.watch((point for point in points if self._sweep.clearance(*point) < self._watched), margin)
        return points

    def _store(self, reading: ProximityReading | LidarReading, spots: list[Point], now: Pose) -> None:
        """Store points of the body frame, at the pose of the tick of the reading."""
        tick = reading.tick
        x, y, heading = now if tick is None else next((pose for at, pose in self._poses if at == tick), now)
        s, c = sincos(heading)
        self._near[reading.id] = [(x + c * px - s * py, y + s * px + c * py) for px, py in spots]

    def _in_frame(self, pose: Pose) -> Iterator[Point]:
        s, c = sincos(pose[2])
        for arc in self._near.values():
            for x, y in arc:
                dx, dy = x - pose[0], y - pose[1]
                yield c * dx + s * dy, c * dy - s * dx

    # ------------------------------------------------------------ what it wants

    def _motion(self, points: list[Point]) -> tuple[float, float]:
        """Return a speed, m/s, and a turn rate, rad/s, after which it can stop."""
        gap, left, right = self._room(points)
        if self._mode == "turn" and self._turned > LEAST_TURN:
            # After each full circle it is content with less.
            wanted = 1.5 * self._stop / (1.0 + self._turned // math.tau)
            if gap > wanted and self._first_free(self._ways_ahead(gap, left, right)) is not None:
                self._mode = "ahead"
        if self._mode == "back" and self._backed > WAY_BACK:
            self._enter_turn(left, right)
        if self._mode == "ahead" and gap < self._stop:
            self._enter_turn(left, right)
        # What it does, and what it does instead if that is blocked.
        order = ORDER[self._mode]
        for mode in [mode for mode in order if not self._shuns(mode)] or order:
            found = self._first_free(self._ways(mode, gap, left, right))
            if found is not None:
                self._begin(mode)
                return found
        return 0.0, 0.0

    def _shuns(self, mode: str) -> bool:
        way = ("turn", -self._side) if mode == "other" else (mode, self._side)
        return way in self._shunned

    def _begin(self, mode: str) -> None:
        if mode == "other":
            self._side, mode = -self._side, "turn"
        if mode != self._mode:
            self._turned = self._backed = 0.0
        self._mode = mode

    def _enter_turn(self, left: float, right: float) -> None:
        self._mode, self._side = "turn", 1.0 if left >= right else -1.0
        self._turned = 0.0

    def _ways(self, mode: str, gap: float, left: float, right: float) -> Iterator[tuple[float, float]]:
        if mode == "ahead":
            yield from self._ways_ahead(gap, left, right)
        elif mode in ("turn", "other"):
            side = self._side if mode == "turn" else -self._side
            yield from ((0.0, side * share * TURN_RATE) for share in SHARES)
        else:
            speed = 0.3 * self._speed if mode == "creep" else -0.4 * self._speed
            yield from ((share * speed, bend) for bend in BENDS for share in SHARES[:4])

    def _ways_ahead(self, gap: float, left: float, right: float) -> Iterator[tuple[float, float]]:
        share = min(1.0, max(0.15, (gap - self._stop) / (self._clear - self._stop)))
        side = 1.0 if left >= right else -1.0
        # To the sides, obstacles count from a quarter of `clear` on.
        bend = max(1.0 - share, 1.0 - min(left, right) / (self._clear / 4.0), 0.0)
        rate = side * bend * TURN_RATE / 2.0
        for part in SHARES[:4]:
            yield self._speed * share * part, rate * part
            for turn in BENDS:
                yield self._speed * share * part, turn * part

    def _first_free(self, ways: Iterator[tuple[float, float]]) -> tuple[float, float] | None:
        return next((way for way in ways if self._sweep.is_free(*way)), None)

    def _room(self, points: list[Point]) -> tuple[float, float, float]:
        """Return the free distance ahead in the strip of the body, and beside it to the left and right, m."""
        body, strip = self._body, self._body.side + MARGIN
        gap = left = right = math.inf
        for x, y in points:
            if x > body.front and abs(y) < strip:
                gap = min(gap, x - body.front)
            if -body.back < x < body.front + self._stop:
                if y > 0.0:
                    left = min(left, max(0.0, y - body.side))
                else:
                    right = min(right, max(0.0, -y - body.side))
        return gap, left, right


def _rays(lidar: Lidar) -> list[tuple[float, float]]:
    """Return sine and cosine of the rays of a full circle: the first is at the right edge of the field of view."""
    start = lidar.direction_deg - lidar.fov_deg / 2.0
    return [sincos(math.radians(start + k * lidar.fov_deg / lidar.rays)) for k in range(lidar.rays)]


def _directions(sensor: Proximity) -> list[tuple[float, float]]:
    """Return sine and cosine of the directions in which the arc of a reading has points; both edges are among them."""
    width, middle = math.radians(sensor.cone_deg), math.radians(sensor.direction_deg)
    pieces = max(1, math.ceil(width / POINT_GAP))
    return [sincos(middle - width / 2.0 + width * k / pieces) for k in range(pieces + 1)]
