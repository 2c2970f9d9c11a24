"""Remembers where obstacles may be around a body, from its proximity sensors and odometry.

A reading says how near an obstacle is inside a cone, but not where in the cone: it may be anywhere on the arc at that
distance, seen from where the sensor was when it measured. The arc is stored as points. A point is removed when a beam
that measured later sees past it, when the body itself stands there, or when it is left far behind. So an obstacle stays
known while it is between two beams.
Points of an arc that were seen free a moment ago do not count, as long as others of the same arc remain. If two
neighbouring beams both see something near, a wall may connect the two: the straight line between their newest arcs
counts too.

Never seen means unknown: a thin obstacle that appears between two beams, or one above or below their height.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from intellwheels_agents import portable_math
from intellwheels_agents.differential_drive import Odometry
from intellwheels_agents.navigation.free_cells import FreeCells
from intellwheels_agents.navigation.point_cells import NEIGHBOURS, Floats, Mask, PointCells, cells_at
from intellwheels_agents.portable_math import cos, dist, hypot, tan
from intellwheels_agents.pure_pursuit import Point
from intellwheels_agents.range_scan import Outline, distance, outline
from intellwheels_schemas.messages import Measures, Proximity, ProximityReading, Robot

CELL: Final = 0.04
"""Default cell size of the grid, m; a cell holds one point."""
SPACING: Final = 1.5
"""Cells between two points of an arc."""
CLEARING: Final = 1.5
"""Cells by which a beam must see past a point, and contain it within its edges, to clear it. That is more than the
diagonal of a cell, so an obstacle in the point's cell, or between it and the next point of its arc, would be seen."""
REACH: Final = 1.5
"""Longest reading that is stored by default, m: what is farther is seen again, nearer, before it matters."""
MAX_AGE: Final = 8.0
"""Age at which a point is dropped, in m of driving (1 rad of turning counts as 1 m): odometry has drifted too far."""
FREE_TIME: Final = 5.0
"""Seconds for which a cell that was seen free counts as free: a person who enters it is not assumed there at once."""
JUMP: Final = 0.03
"""Metres by which a reading may shrink in a tick beyond the body's own motion; a larger step is a new obstacle."""
LOOK_INTERVAL: Final = 0.1
"""Distance between two updates of the free cells, in m of driving (1 rad of turning counts as 1 m)."""
LOOK_CELLS: Final = 6000
"""Free cells that are noted in a tick, at least those of one beam: the beams take turns, so that no tick is long."""
LONE_AGE: Final = 0.3
"""Age at which a point without neighbours is dropped, in m of driving (1 rad of turning counts as 1 m). A real
obstacle is seen from several places, and each leaves a point beside the last."""
WALL_GAP: Final = 0.8
"""Longest gap between two beams' arcs that a wall is assumed to close, m."""
_POSES_KEPT: Final = 40

Pose = tuple[float, float, float]

sincos = lru_cache(maxsize=256)(portable_math.sincos)
"""Each beam asks for the directions of the body and of its own edges."""


@dataclass(frozen=True, slots=True)
class _Beam:
    """A sensor on the body: its position (m), bearing and half cone angle (rad), and what clearing needs.

    `tangent` is that of the half angle, `slack` the margin to the edge of the cone (m). The cells in the cone have
    places in the body's frame, `lattice_x` and `lattice_y`, and distances from the sensor, `lattice_far`, the nearest
    first (m). `arcs` has the sines and cosines of arcs by their number of pieces.
    """

    sensor: Proximity
    x: float
    y: float
    bearing: float
    half: float
    tangent: float
    slack: float
    lattice_x: Floats
    lattice_y: Floats
    lattice_far: Floats
    arcs: dict[int, tuple[Floats, Floats]]

    def at(self, angle: float, metres: float) -> Point:
        """Return the point at an angle from the beam's axis (rad) and a distance (m), in the body frame."""
        s, c = sincos(self.bearing + angle)
        return self.x + metres * c, self.y + metres * s

    def arc(self, radius: float, spacing: float) -> tuple[Floats, Floats]:
        """Return the points of an arc about the sensor from edge to edge of the cone, in the body's frame, m."""
        pieces = max(1, math.ceil(2.0 * self.half * radius / spacing))
        if pieces not in self.arcs:
            first = self.bearing - self.half
            turned = np.array([sincos(first + 2.0 * self.half * k / pieces) for k in range(pieces + 1)])
            self.arcs[pieces] = turned[:, 0], turned[:, 1]
        s, c = self.arcs[pieces]
        return self.x + radius * c, self.y + radius * s


class _Sight(NamedTuple):
    """The last range of a sensor (m), its tick, and the pose of the body at that tick."""

    metres: float
    tick: int
    pose: Pose


class ObstacleMemory:
    """The possible places of obstacles around a body.

    Attributes:
        points: Possible obstacle points within the reach of the body, in the frame of the body at the last pose that
            it was given: an array of shape (n, 2), m.
    """

    def __init__(self, robot: Robot, cell: float = CELL, reach: float = REACH) -> None:
        """Take the sensors of `robot` that move with it, the size of a cell, and the longest reading stored, m."""
        self._cell, self._spacing, self._clearing, self._reach = cell, SPACING * cell, CLEARING * cell, reach
        self.points: Floats = np.empty((0, 2))
        self._outline = outline(robot)
        self._beams = {sensor.id: _beam(sensor, cell, reach) for sensor in robot.proximity if sensor.mount == "body"}
        self._stored = PointCells()
        self._poses: deque[tuple[int, Pose, float]] = deque(maxlen=_POSES_KEPT)
        self._early: list[tuple[int, ProximityReading]] = []
        self._travel = 0.0
        self._looked_at = -math.inf
        self._to_look: dict[str, None] = {}
        # What is older than `FREE_TIME` at a look does not count.
        self._free = FreeCells()
        self._looked_time = -math.inf
        self._last: dict[str, _Sight] = {}
        self._covered = _lattice_of(self._outline, cell)
        self._ring = sorted(self._beams, key=lambda name: math.remainder(self._beams[name].bearing, math.tau))

    def update(self, measures: Measures, odometry: Odometry) -> None:
        """Update with the readings of a tick.

        Args:
            measures: The measures; a reading is placed where the body was at the tick at which it was taken.
            odometry: The pose estimate, already updated with the same measures. If its tick is older than that of a
                reading, the reading waits until the pose is known.
        """
        pose = odometry.x, odometry.y, odometry.heading
        now = measures.tick if odometry.tick is None else odometry.tick
        if self._poses:
            self._travel += _between(self._poses[-1][1], pose)
        if self._poses and self._poses[-1][0] == now:
            self._poses.pop()
        self._poses.append((now, pose, measures.time))
        self._keep_near(pose)
        looks = self._travel - self._looked_at >= LOOK_INTERVAL
        if looks:
            self._looked_at = self._travel
            self._looked_time = measures.time
            self._set_free(pose, *self._covered, measures.time)
            self._drop_lone()
            self._to_look.update(dict.fromkeys(self._beams))
        room = LOOK_CELLS
        for tick, reading in self._due(measures, now):
            beam = self._beams.get(reading.id)
            metres = None if beam is None else distance(reading, beam.sensor)
            if beam is None or metres is None:
                self._last.pop(reading.id, None)
                continue
            last, found = self._last.get(reading.id), self._pose_at(tick)
            # A sensor that is slower than the simulation repeats its reading, which counts once.
            if found is None or (last is not None and last.tick >= tick):
                continue
            then, time = found
            self._clear(beam, min(metres, beam.sensor.max_range), then, tick)
            if reading.id == next(iter(self._to_look), None) or (reading.id in self._to_look and room > 0):
                del self._to_look[reading.id]
                room -= len(beam.lattice_far)
                count = int(np.searchsorted(beam.lattice_far, metres - self._clearing))
                self._set_free(then, beam.lattice_x[:count], beam.lattice_y[:count], time)
            appeared = last is None or metres < last.metres - JUMP - _between(last.pose, then)
            self._last[reading.id] = _Sight(metres, tick, then)
            self._mark(beam, reading, metres, then, tick, appeared)
        walls = np.array(list(self._walls_between(pose))).reshape(-1, 2)
        self.points = np.concatenate([self._stored.here(), walls])

    def _due(self, measures: Measures, now: int) -> list[tuple[int, ProximityReading]]:
        """Return the readings whose poses are known by now, with their ticks."""
        readings = self._early + [
            (measures.tick if reading.tick is None else reading.tick, reading)
            for reading in (measures.sensors.proximity if measures.sensors else ())
        ]
        self._early = [(tick, reading) for tick, reading in readings if tick > now]
        return [(tick, reading) for tick, reading in readings if tick <= now]

    def _pose_at(self, tick: int) -> tuple[Pose, float] | None:
        """Return the pose at a tick, and its time."""
        return next(((pose, time) for at, pose, time in self._poses if at == tick), None)

    def _keep_near(self, pose: Pose) -> None:
        """Place the points in the body's frame; drop those that are far, old, or covered by the body."""
        px, py, heading = pose
        s, c = sincos(heading)
        body, stored = self._outline, self._stored
        reach = self._reach + max(body.front, body.back)
        stored.drop_dead()
        dx, dy = stored.values[stored.MAP_X] - px, stored.values[stored.MAP_Y] - py
        stored.values[stored.X], stored.values[stored.Y] = c * dx + s * dy, c * dy - s * dx
        x, y = stored.values[stored.X], stored.values[stored.Y]
        near = (np.abs(x) < reach) & (np.abs(y) < reach) & (stored.values[stored.TRAVEL] >= self._travel - MAX_AGE)
        stored.drop(~near | _within(body, x, y))
        stored.drop_dead()

    def _clear(self, beam: _Beam, metres: float, then: Pose, tick: int) -> None:
        """Drop the points that a beam saw past from a pose, and that no later reading saw."""
        clear, stored = metres - self._clearing, self._stored
        if clear <= 0.0 or not stored.cell.size:
            return
        # A point of the body's frame now, in that of the beam then: turned by (turn_s, turn_c), then moved.
        now = self._poses[-1][1]
        s, c = sincos(beam.bearing)
        off_x, off_y = -(c * beam.x + s * beam.y), s * beam.x - c * beam.y
        if then != now:
            then_s, then_c = sincos(then[2])
            dx, dy = now[0] - then[0], now[1] - then[1]
            moved_x, moved_y = then_c * dx + then_s * dy, then_c * dy - then_s * dx
            off_x, off_y = off_x + c * moved_x + s * moved_y, off_y + c * moved_y - s * moved_x
            s, c = sincos(beam.bearing + then[2] - now[2])
        x, y = stored.values[stored.X], stored.values[stored.Y]
        along = c * x + s * y + off_x
        passed = (along > 0.0) & (along < clear)
        # Most beams have no point before them that they see past.
        if not passed.any():
            return
        across = np.abs(c * y - s * x + off_y)
        passed &= across < along * beam.tangent - beam.slack
        if passed.any():
            passed &= (along * along + across * across < clear * clear) & (stored.values[stored.TICK] <= tick)
            stored.drop(passed)

    def _drop_lone(self) -> None:
        stored = self._stored
        lone = stored.live & (stored.values[stored.TRAVEL] < self._travel - LONE_AGE)
        known = stored.columns.keys()
        lone[lone] = [known.isdisjoint(map(cell.__add__, NEIGHBOURS)) for cell in stored.cell[lone].tolist()]
        stored.drop(lone)

    def _set_free(self, pose: Pose, x: Floats, y: Floats, time: float) -> None:
        """Note when cells were seen free, by places in the body's frame at a pose."""
        px, py, heading = pose
        s, c = sincos(heading)
        self._free.note(cells_at(px + c * x - s * y, py + s * x + c * y, self._cell), time)

    def _mark(
        self,
        beam: _Beam,
        reading: ProximityReading,
        metres: float,
        then: Pose,
        tick: int,
        appeared: bool,
    ) -> None:
        """Store the arc of a reading; `appeared` says that the obstacle is new, so cells seen free may hold it."""
        if metres > min(self._reach, beam.sensor.max_range):
            return
        # Nearer than the sensor's minimum range: an arc at half of it is wrong by at most that half.
        radius = metres / 2.0 if reading.status == "near" else metres
        x, y, heading = self._poses[-1][1]
        s, c = sincos(heading)
        then_x, then_y, turned = then
        then_s, then_c = sincos(turned)
        bx, by = beam.arc(radius, self._spacing)
        map_x, map_y = then_x + then_c * bx - then_s * by, then_y + then_s * bx + then_c * by
        dx, dy = map_x - x, map_y - y
        here_x, here_y = c * dx + s * dy, c * dy - s * dx
        outside = ~_within(self._outline, here_x, here_y)
        cells = cells_at(map_x, map_y, self._cell)
        if not appeared:
            possible = outside & ~(self._looked_time - self._free.times(cells) <= FREE_TIME)
            outside = possible if possible.any() else outside
        self._stored.put(cells[outside], map_x[outside], map_y[outside], here_x[outside], here_y[outside],
                         self._travel, tick)  # fmt: skip
        self._free.forget(cells[outside])

    def _walls_between(self, now: Pose) -> Iterator[Point]:
        """Yield points of the walls that may connect the arcs of neighbouring beams, in the frame of the body now."""
        for first, second in zip(self._ring, self._ring[1:] + self._ring[:1], strict=True):
            near, far = self._last.get(first), self._last.get(second)
            # Both of the newest readings: an older one no longer says what is there.
            if first == second or near is None or far is None or near.tick != far.tick:
                continue
            if max(near.metres, far.metres) > self._reach:
                continue
            one, other = self._beams[first], self._beams[second]
            a, b = one.at(one.half, near.metres), other.at(-other.half, far.metres)
            length = dist(a, b)
            if length < WALL_GAP:
                pieces = max(1, math.ceil(length / self._spacing))
                for k in range(1, pieces):
                    point = a[0] + (b[0] - a[0]) * k / pieces, a[1] + (b[1] - a[1]) * k / pieces
                    yield point if near.pose == now else _seen_from(now, near.pose, point)


def _between(one: Pose, other: Pose) -> float:
    """Return how far a body moves between two poses, m; a turn of 1 rad counts as 1 m."""
    turned = math.remainder(other[2] - one[2], math.tau)
    return hypot(other[0] - one[0], other[1] - one[1]) + abs(turned)


def _seen_from(now: Pose, then: Pose, point: Point) -> Point:
    """Return a point of the body's frame at one pose in its frame at another."""
    s, c = sincos(then[2])
    dx, dy = then[0] + c * point[0] - s * point[1] - now[0], then[1] + s * point[0] + c * point[1] - now[1]
    s, c = sincos(now[2])
    return c * dx + s * dy, c * dy - s * dx


def _beam(sensor: Proximity, cell: float, reach: float) -> _Beam:
    half = min(math.radians(sensor.cone_deg) / 2.0, math.radians(89.0))
    bearing, tangent, slack = math.radians(sensor.direction_deg), tan(half), CLEARING * cell / cos(half)
    s, c = sincos(bearing)
    count = math.ceil(reach / cell)
    along, across = np.meshgrid(cell * np.arange(1, count + 1), cell * np.arange(-count, count + 1))
    inside = np.abs(across) < along * tangent - slack
    along, across = along[inside], across[inside]
    far = np.sqrt(along * along + across * across)
    nearest = np.argsort(far, kind="stable")
    along, across, far = along[nearest], across[nearest], far[nearest]
    x, y = sensor.x + c * along - s * across, sensor.y + s * along + c * across
    return _Beam(sensor, sensor.x, sensor.y, bearing, half, tangent, slack, x, y, far, {})


def _lattice_of(body: Outline, cell: float) -> tuple[Floats, Floats]:
    """Return points that cover a body, far enough inside that all their cells are inside too, as x and y."""
    edge = CLEARING * cell
    inside = Outline(body.front - edge, body.back - edge, body.side - edge)
    x, y = np.meshgrid(
        cell * np.arange(-math.floor(body.back / cell), math.ceil(body.front / cell)),
        cell * np.arange(-math.floor(body.side / cell), math.ceil(body.side / cell)),
    )
    covered = _within(inside, x, y)
    return x[covered], y[covered]


def _within(body: Outline, x: Floats, y: Floats) -> Mask:
    return (-body.back < x) & (x < body.front) & (np.abs(y) < body.side)
