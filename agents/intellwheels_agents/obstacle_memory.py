"""Where something may stand around a body, remembered from its proximity sensors.

A reading says how near something is inside a cone, not where in it: every point of the arc at that distance may be it.
The arc is kept as points, carried along by odometry, until a later cone proves a point free by seeing past it, the body
itself stands there, or it is left behind. So what slips between two cones is still known, once one of them saw it.
Of an arc only those points count that were not proven free a moment ago, if there are others. Between two cones
beside one another that both see something near, a wall may stand: the straight line between them counts while they do.

What no cone ever saw is not known: a thin thing that appears between two cones, or above or below their height.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator
from typing import Final, NamedTuple

from intellwheels_agents.differential_drive import Odometry
from intellwheels_agents.range_scan import Outline, distance, outline
from intellwheels_schemas.messages import Measures, Proximity, ProximityReading, Robot

CELL: Final = 0.04
"""Metres of the raster in which one point is kept, unless it is made finer."""
SPACING: Final = 1.5
"""Cells between the points of an arc."""
PROOF: Final = 1.5
"""Cells by which a cone must see past a point, and hold it within its edges, to prove it free: whatever stood in the
point's cell, whose diagonal is less, or between it and the next of its arc, would have been seen."""
REACH: Final = 1.5
"""Metres up to which a reading is kept: what is further is seen again, nearer, before it matters."""
FORGOTTEN: Final = 8.0
"""Metres of driving, a radian of turning counted as one, after which odometry is trusted no more."""
FREE: Final = 5.0
"""Seconds for which what was proven free counts as free: a person who walks in is believed later than that."""
JUMP: Final = 0.03
"""Metres by which a reading may shrink in a tick beyond what the body moved; by more, something came."""
LOOK: Final = 0.1
"""Metres of driving, a radian of turning counted as one, between two looks at what is free."""
LONE: Final = 0.3
"""Metres of driving, a radian of turning counted as one, after which a point without a neighbour is forgotten: what
is really there is seen from several places, and each leaves a point a little beside the last."""
BRIDGE: Final = 0.8
"""Metres between two cones' arcs that a wall may bridge."""
_PAST: Final = 40
_BESIDE: Final = tuple((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j)

Pose = tuple[float, float, float]
Cell = tuple[int, int]
Point = tuple[float, float]


class _Beam(NamedTuple):
    """A sensor on the body: place, direction, and its cone's half angle as tangent and lengths of the proof."""

    sensor: Proximity
    x: float
    y: float
    bearing: float
    half: float
    tangent: float
    slack: float
    lattice: tuple[tuple[float, float, float], ...]

    def at(self, angle: float, metres: float) -> Point:
        """Return the place at an angle from its middle and a distance from it, in the body's frame."""
        return self.x + metres * math.cos(self.bearing + angle), self.y + metres * math.sin(self.bearing + angle)


class ObstacleMemory:
    """What may stand around a body.

    Attributes:
        points: (x, y) in the body's own frame, metres, of all that may be something within `REACH` of the body.
    """

    def __init__(self, robot: Robot, cell: float = CELL) -> None:
        """Take the sensors of `robot` that ride on it, and the raster's cell, m."""
        self._cell, self._spacing, self._proof = cell, SPACING * cell, PROOF * cell
        self.points: list[Point] = []
        self._outline = outline(robot)
        self._eyes = {sensor.id: _eye(sensor, cell) for sensor in robot.proximity if sensor.mount == "body"}
        self._cells: dict[Cell, tuple[float, float, float]] = {}
        self._poses: deque[tuple[int, Pose]] = deque(maxlen=_PAST)
        self._travel = 0.0
        self._step = 0.0
        self._looked = -math.inf
        self._free: dict[Cell, float] = {}
        self._last: dict[str, float] = {}
        self._stand = _lattice_of(self._outline, cell)
        self._ring = sorted(self._eyes, key=lambda name: math.remainder(self._eyes[name].bearing, math.tau))

    def update(self, measures: Measures, odometry: Odometry) -> None:
        """Take the readings of a tick.

        Args:
            measures: A reading that says an older tick is put where the body was then.
            odometry: Updated with the same measures.
        """
        pose = odometry.x, odometry.y, odometry.heading
        if self._poses:
            x, y, heading = self._poses[-1][1]
            turned = math.remainder(pose[2] - heading, math.tau)
            self._step = math.hypot(pose[0] - x, pose[1] - y) + abs(turned)
            self._travel += self._step
        self._poses.append((measures.tick, pose))
        local = self._around(pose)
        looks = self._travel - self._looked >= LOOK
        if looks:
            self._looked = self._travel
            self._free = {cell: time for cell, time in self._free.items() if measures.time - time <= FREE}
            self._set_free(pose, self._stand, measures.time)
            self._forget_lone(local)
        ranges: dict[str, float] = {}
        for reading in measures.sensors.proximity if measures.sensors else ():
            eye = self._eyes.get(reading.id)
            metres = None if eye is None else distance(reading, eye.sensor)
            if eye is None or metres is None:
                continue
            then = self._pose_at(reading.tick)
            if then is None:
                continue
            # An old look proves nothing of what was seen since.
            if then == pose:
                ranges[reading.id] = metres
                self._prove_free(eye, min(metres, eye.sensor.max_range), local)
                if looks:
                    clear = metres - self._proof
                    self._set_free(pose, [(x, y) for x, y, far in eye.lattice if far < clear], measures.time)
            came = metres < self._last.get(reading.id, math.inf) - JUMP - self._step
            self._mark(eye, reading, metres, then, local, came)
        self._last = ranges
        self.points = [*local.values(), *self._bridges(ranges)]

    def _pose_at(self, tick: int | None) -> Pose | None:
        if tick is None:
            return self._poses[-1][1]
        return next((pose for at, pose in self._poses if at == tick), None)

    def _around(self, pose: Pose) -> dict[Cell, Point]:
        """Return what is near in the body's frame; forget what is far, old, or where the body stands."""
        px, py, heading = pose
        c, s = math.cos(heading), math.sin(heading)
        body = self._outline
        reach = REACH + max(body.front, body.back)
        oldest = self._travel - FORGOTTEN
        near: dict[Cell, Point] = {}
        gone = []
        for cell, (wx, wy, travel) in self._cells.items():
            dx, dy = wx - px, wy - py
            x, y = c * dx + s * dy, c * dy - s * dx
            if travel < oldest or not (-reach < x < reach and -reach < y < reach) or _within(body, x, y):
                gone.append(cell)
            else:
                near[cell] = x, y
        for cell in gone:
            del self._cells[cell]
        return near

    def _prove_free(self, eye: _Beam, metres: float, local: dict[Cell, Point]) -> None:
        c, s = math.cos(eye.bearing), math.sin(eye.bearing)
        clear = metres - self._proof
        if clear <= 0.0:
            return
        behind, tangent, slack = c * eye.x + s * eye.y, eye.tangent, eye.slack
        aside = c * eye.y - s * eye.x
        proved = []
        for cell, (x, y) in local.items():
            along = c * x + s * y - behind
            if not 0.0 < along < clear:
                continue
            across = abs(c * y - s * x - aside)
            if across < along * tangent - slack and along * along + across * across < clear * clear:
                proved.append(cell)
        for cell in proved:
            del local[cell], self._cells[cell]

    def _forget_lone(self, local: dict[Cell, Point]) -> None:
        cells = self._cells
        lone = [
            (i, j)
            for i, j in local
            if cells[i, j][2] < self._travel - LONE and not any((i + di, j + dj) in cells for di, dj in _BESIDE)
        ]
        for cell in lone:
            del local[cell], cells[cell]

    def _set_free(self, pose: Pose, places: Iterable[Point], time: float) -> None:
        px, py, heading = pose
        c, s = math.cos(heading), math.sin(heading)
        for x, y in places:
            at = math.floor((px + c * x - s * y) / self._cell), math.floor((py + s * x + c * y) / self._cell)
            self._free[at] = time

    def _mark(
        self, eye: _Beam, reading: ProximityReading, metres: float, then: Pose, local: dict[Cell, Point], came: bool
    ) -> None:
        if metres > min(REACH, eye.sensor.max_range):
            return
        # Nearer than a sensor can tell: the arc halfway is never further than the thing by more than that half.
        radius = metres / 2.0 if reading.status == "near" else metres
        x, y, heading = self._poses[-1][1]
        c, s = math.cos(heading), math.sin(heading)
        then_x, then_y, turned = then
        then_c, then_s = math.cos(turned), math.sin(turned)
        steps = max(1, math.ceil(2.0 * eye.half * radius / self._spacing))
        arc: list[tuple[Cell, Point, Point]] = []
        for k in range(steps + 1):
            angle = eye.bearing - eye.half + 2.0 * eye.half * k / steps
            bx, by = eye.x + radius * math.cos(angle), eye.y + radius * math.sin(angle)
            wx, wy = then_x + then_c * bx - then_s * by, then_y + then_s * bx + then_c * by
            dx, dy = wx - x, wy - y
            here = c * dx + s * dy, c * dy - s * dx
            if not _within(self._outline, *here):
                arc.append(((math.floor(wx / self._cell), math.floor(wy / self._cell)), (wx, wy), here))
        doubtful = arc if came else [entry for entry in arc if entry[0] not in self._free]
        for cell, (wx, wy), here in doubtful or arc:
            self._cells[cell] = (wx, wy, self._travel)
            local[cell] = here
            self._free.pop(cell, None)

    def _bridges(self, ranges: dict[str, float]) -> Iterator[Point]:
        """Yield points of the walls that may stand between cones beside one another."""
        for first, second in zip(self._ring, self._ring[1:] + self._ring[:1], strict=True):
            one, other = self._eyes[first], self._eyes[second]
            near, far = ranges.get(first, math.inf), ranges.get(second, math.inf)
            if first == second or max(near, far) > REACH:
                continue
            a, b = one.at(one.half, near), other.at(-other.half, far)
            length = math.dist(a, b)
            if length < BRIDGE:
                pieces = max(1, math.ceil(length / self._spacing))
                for k in range(1, pieces):
                    yield a[0] + (b[0] - a[0]) * k / pieces, a[1] + (b[1] - a[1]) * k / pieces


def _eye(sensor: Proximity, cell: float) -> _Beam:
    half = min(math.radians(sensor.cone_deg) / 2.0, math.radians(89.0))
    bearing, tangent, slack = math.radians(sensor.direction_deg), math.tan(half), PROOF * cell / math.cos(half)
    c, s = math.cos(bearing), math.sin(bearing)
    count = math.ceil(REACH / cell)
    lattice = tuple(
        (sensor.x + c * along - s * across, sensor.y + s * along + c * across, math.hypot(along, across))
        for along in (cell * i for i in range(1, count + 1))
        for across in (cell * j for j in range(-count, count + 1))
        if abs(across) < along * tangent - slack
    )
    return _Beam(sensor, sensor.x, sensor.y, bearing, half, tangent, slack, lattice)


def _lattice_of(body: Outline, cell: float) -> tuple[Point, ...]:
    """Return places all over a body, far enough within that all of their cells are."""
    edge = PROOF * cell
    inside = Outline(body.front - edge, body.back - edge, body.side - edge)
    return tuple(
        (x, y)
        for x in (cell * i for i in range(-math.floor(body.back / cell), math.ceil(body.front / cell)))
        for y in (cell * j for j in range(-math.floor(body.side / cell), math.ceil(body.side / cell)))
        if _within(inside, x, y)
    )


def _within(body: Outline, x: float, y: float) -> bool:
    return -body.back < x < body.front and abs(y) < body.side
