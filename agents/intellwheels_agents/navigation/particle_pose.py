"""Where a body is on the map: odometry, corrected by matching what the sensors see with the map, by a particle filter.

A particle is a pose that the body may have. It moves as the odometry says, with noise of its own; its weight is how
well the sensed points lie on the map as seen from it. A point that is nowhere near the map counts little against any
pose, because people and chairs are not on the map. A cone of a proximity sensor sees its point somewhere on an arc: the
place of the arc that is nearest to the map counts.

The noise follows from the agent's name, so a run repeats.

Source: S. Thrun, W. Burgard, D. Fox, Probabilistic Robotics, MIT Press 2005: Monte Carlo localisation (table 8.2), the
likelihood field (table 6.3), the low-variance sampler (table 4.4). The kernel here is 1 / (1 + (d / s)^2) in place of
the Gaussian: it needs no exponential, and far points do not decide.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from intellwheels_agents.differential_drive import Odometry, wrapped
from intellwheels_agents.navigation.array_angles import Floats, sines, wrapped_all
from intellwheels_agents.navigation.map_distance import MapDistance
from intellwheels_agents.navigation.scan_points import Pose
from intellwheels_agents.portable_math import hypot, sincos
from intellwheels_agents.range_scan import distance
from intellwheels_schemas.messages import Measures, Position, Proximity, Robot

PARTICLES: Final = 120
POINTS: Final = 48
"""Points of the scans that are matched in a tick."""
START_NOISE: Final = (0.02, 0.01)
"""Standard deviations of the start, m and rad."""
WAY_NOISE: Final = 0.06
"""Standard deviation of a moved distance, as a share of it."""
TURN_NOISE: Final = 0.06
"""Standard deviation of a turned angle, as a share of it."""
DRIFT_NOISE: Final = 0.06
"""Standard deviation of the turn that a move adds, rad per m."""
SIGMA: Final = 0.08
"""Distance to the map at which a point counts half, m."""
LOST: Final = 0.05
"""What a point counts at least: it may be on something that is not on the map."""
EVERY: Final = 0.03
"""Distance between two matches, m of way (1 rad counts as 1 m)."""
TO_UNIT: Final = 1.0 / 9007199254740992.0
"""A whole number of 53 bits times this is in [0, 1)."""
ROOT_3: Final = 1.7320508075688772
HISTORY: Final = 64
ARC: Final = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Where on the arc of a cone the point may be, in halves of its angle."""


class ParticlePose:
    """The estimated pose of one body.

    Attributes:
        pose: The pose.
        tick: The tick at which the body was there: that of the encoders.
    """

    def __init__(self, robot: Robot, start: Position, field: MapDistance, name: str) -> None:
        """Start at the pose at which the body joined."""
        self._odometry = Odometry(robot, start)
        self._field = field
        self._cones = {sensor.id: (sensor, *_arc(sensor)) for sensor in robot.proximity if sensor.mount == "body"}
        self._draw = np.random.PCG64(int.from_bytes(name.encode()[:16], "big"))
        noise = self._noise(3)
        self._x = start.x + START_NOISE[0] * noise[0]
        self._y = start.y + START_NOISE[0] * noise[1]
        self._heading = start.heading + START_NOISE[1] * noise[2]
        self._weight = np.full(PARTICLES, 1.0 / PARTICLES)
        self._last: Pose = (start.x, start.y, start.heading)
        self._then: dict[int, Pose] = {}
        self._moved = 0.0
        self.tick = 0
        self._waiting: list[tuple[int, Floats]] = []
        self.pose: Pose = self._last

    def update(self, measures: Measures, scans: list[tuple[int, Floats]]) -> Pose:
        """Return the pose after the measures of a tick; `tick` is its tick.

        Args:
            measures: The measures.
            scans: The tick of each scan, and its points in the body's frame at that tick, m.
        """
        self._odometry.update(measures.sensors)
        now = self._odometry.x, self._odometry.y, self._odometry.heading
        self._move(now)
        tick = self._odometry.tick
        self.tick = measures.tick if tick is None else tick
        self._then[self.tick] = now
        self._then.pop(self.tick - HISTORY, None)
        # A scan that is newer than the encoders waits for them.
        scans = self._waiting + scans
        self._waiting = [(at, points) for at, points in scans if at > self.tick]
        if self._moved >= EVERY:
            self._moved = 0.0
            self._match(measures, scans, now)
        self.pose = self._mean(self.pose[2])
        return self.pose

    def _noise(self, rows: int) -> Floats:
        """Return rows of numbers with mean 0 and standard deviation 1, one for each particle."""
        raw = self._draw.random_raw(4 * rows * PARTICLES).reshape(4, rows, PARTICLES)
        uniform = (raw >> np.uint64(11)).astype(np.float64) * TO_UNIT
        return np.asarray((uniform[0] + uniform[1] + uniform[2] + uniform[3] - 2.0) * ROOT_3)

    def _move(self, now: Pose) -> None:
        s, c = sincos(self._last[2])
        dx, dy = now[0] - self._last[0], now[1] - self._last[1]
        along, across, turn = c * dx + s * dy, c * dy - s * dx, wrapped(now[2] - self._last[2])
        self._last = now
        way = hypot(along, across)
        if way + abs(turn) < 1e-6:
            return
        self._moved += way + abs(turn)
        noise = self._noise(3)
        along_all = along + WAY_NOISE * way * noise[0]
        turn_all = turn + (TURN_NOISE * abs(turn) + DRIFT_NOISE * way) * noise[1]
        across_all = across + 0.3 * WAY_NOISE * way * noise[2]
        sine, cosine = sines(self._heading)
        self._x = self._x + cosine * along_all - sine * across_all
        self._y = self._y + sine * along_all + cosine * across_all
        self._heading = self._heading + turn_all

    def _match(self, measures: Measures, scans: list[tuple[int, Floats]], now: Pose) -> None:
        parts = [self._since(tick, points, now) for tick, points in scans if tick in self._then]
        points = np.concatenate(parts) if parts else np.zeros((0, 2))
        if points.shape[0]:
            points = points[:: max(1, points.shape[0] // POINTS)]
            score = self._scores(points).prod(axis=0)
            # Neighbouring points say nearly the same: a quarter of their evidence counts.
            self._weight = self._weight * np.sqrt(np.sqrt(score))
        elif measures.sensors is not None:
            self._weight = self._weight * self._cone_scores(measures, now)
        total = float(np.cumsum(self._weight)[-1])
        if total <= 0.0:
            self._weight = np.full(PARTICLES, 1.0 / PARTICLES)
            return
        self._weight = self._weight / total
        if 1.0 / float(np.cumsum(self._weight * self._weight)[-1]) < PARTICLES / 2.0:
            self._resample()

    def _since(self, tick: int, points: Floats, now: Pose) -> Floats:
        """Return points of the body's frame at an earlier tick in its frame now."""
        then = self._then[tick]
        if then == now:
            return points
        s, c = sincos(then[2])
        x, y = (
            then[0] + c * points[:, 0] - s * points[:, 1] - now[0],
            then[1] + s * points[:, 0] + c * points[:, 1] - now[1],
        )
        s, c = sincos(now[2])
        return np.stack([c * x + s * y, c * y - s * x], axis=1)

    def _scores(self, points: Floats) -> Floats:
        """Return how well points lie on the map, by point and particle."""
        s, c = sines(self._heading)
        px, py = points[:, 0][:, None], points[:, 1][:, None]
        share = self._field.between(self._x + c * px - s * py, self._y + s * px + c * py) / SIGMA
        return LOST + (1.0 - LOST) / (1.0 + share * share)

    def _cone_scores(self, measures: Measures, now: Pose) -> Floats:
        arcs = []
        for reading in measures.sensors.proximity if measures.sensors else ():
            cone = self._cones.get(reading.id)
            metres = None if cone is None or reading.status != "ok" else distance(reading, cone[0])
            tick = measures.tick if reading.tick is None else reading.tick
            if cone is None or metres is None or tick not in self._then:
                continue
            sensor, ahead, aside = cone
            # A sensor that is slower than the simulation repeats its reading, which counts once.
            if measures.tick - tick <= sensor.latency + sensor.every:
                arc = np.stack([sensor.x + metres * ahead, sensor.y + metres * aside], axis=1)
                arcs.append(self._since(tick, arc, now))
        if not arcs:
            return np.ones(PARTICLES)
        best = self._scores(np.concatenate(arcs)).reshape(len(arcs), len(ARC), PARTICLES).max(axis=1)
        return np.asarray(np.sqrt(best.prod(axis=0)))

    def _resample(self) -> None:
        first = float(self._draw.random_raw() >> 11) * TO_UNIT
        marks = (np.arange(PARTICLES) + first) / PARTICLES
        chosen = np.minimum(np.searchsorted(np.cumsum(self._weight), marks), PARTICLES - 1)
        self._x, self._y, self._heading = self._x[chosen], self._y[chosen], self._heading[chosen]
        self._weight = np.full(PARTICLES, 1.0 / PARTICLES)

    def _mean(self, near: float) -> Pose:
        weight = self._weight
        turned = wrapped_all(self._heading - near)
        return (
            float(np.cumsum(weight * self._x)[-1]),
            float(np.cumsum(weight * self._y)[-1]),
            wrapped(near + float(np.cumsum(weight * turned)[-1])),
        )


def _arc(sensor: Proximity) -> tuple[Floats, Floats]:
    """Return the cosines and sines of the directions in a cone where its point may be, in the body's frame."""
    s, c = sines((sensor.direction_deg + np.array(ARC) * sensor.cone_deg / 2.0) * (math.pi / 180.0))
    return c, s
