"""All sensors of all bodies in one call see what each would see alone, box by box, by GEOS."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from shapely.geometry import Point, Polygon

from intellwheels_server.world.kernels.arrays import Floats, Ints, Walls
from intellwheels_server.world.kernels.proximity_wedges import STATUS_NEAR, STATUS_NONE, STATUS_OK, sense_proximity
from intellwheels_server.world.kernels.sample_schedule import DEPTH, EVERY, FIRST_SAMPLE, SCHEDULE_COLUMNS
from intellwheels_server.world.wall_pieces import Line, Solid, walls_from

_FAR = 50.0


class _Scene:
    """Bodies of one or two boxes, walls of all sorts, several sensors a body."""

    def __init__(self, seed: int, bodies: int, sensors: int) -> None:
        random = np.random.default_rng(seed)
        size = 2.0 * math.sqrt(bodies)
        self.pose: Floats = random.uniform(-size, size, (3, bodies))
        self.pose[2] = random.uniform(-math.pi, math.pi, bodies)
        self.parts: Floats = np.array(
            [
                [random.uniform(-0.5, 0.5), random.uniform(-0.2, 0.2), *random.uniform(0.02, 0.6, 2), z, z + 0.5]
                for _ in range(bodies)
                for z in (0.0, 0.5)
            ]
        )
        self.part_start: Ints = np.arange(bodies + 1) * 2
        self.solids = [_ring(random, size) for _ in range(bodies)]
        self.walls = walls_from(
            [Solid(corners, 0.0, 0.6) for corners in self.solids]
            + [
                Line([(-size, -size), (size, -size), (size, size)], 0.2, 0.2, 2.0),
                Line([(0, 0), (size, 1)], 0.1, 0.0, 1.0),
            ]
        )
        count = bodies * sensors
        half = random.choice([math.radians(15), math.radians(60), math.radians(130), math.pi / 2, math.pi], count)
        direction = random.uniform(-math.pi, math.pi, count)
        self.eyes: Floats = np.column_stack(
            [
                random.uniform(-0.6, 0.6, (count, 2)),
                random.choice([0.1, 0.5, 0.7], count),
                np.cos(direction),
                np.sin(direction),
                np.cos(half),
                np.where(half < math.pi, np.sin(half), 0.0),
                np.full(count, 0.05),
                random.choice([1.0, 4.0, 12.0], count),
            ]
        )
        self.angles = np.column_stack([direction, half])
        self.stations: Floats = np.zeros((bodies, 4))
        self.crews: Ints = np.zeros((bodies, 4), dtype=np.int64)
        for body in range(bodies):
            self.crews[body] = body, 0, body * sensors, (body + 1) * sensors
            self.stations[body, 3] = max(
                math.hypot(e[0], e[1]) + e[8] for e in self.eyes[self.crews[body, 2] :][:sensors]
            )
        self.schedule: Ints = np.zeros((count, SCHEDULE_COLUMNS), dtype=np.int64)
        self.schedule[:, EVERY] = self.schedule[:, DEPTH] = 1
        self.schedule[:, FIRST_SAMPLE] = np.arange(count) * 2

    def seen(self) -> Floats:
        samples = np.full(2 * len(self.eyes), np.nan)
        sense_proximity(
            0,
            self.pose,
            self.parts,
            self.part_start,
            *self.walls,
            self.stations,
            self.crews,
            self.eyes,
            self.schedule,
            samples,
        )
        return samples.reshape(-1, 2)

    def by_geos(self, sensor: int) -> float:
        """Return the distance to whatever is in the wedge at the sensor's height, inf for nothing."""
        owner = sensor * len(self.crews) // len(self.eyes)
        x, y = self._to_world(owner, self.eyes[sensor, 0], self.eyes[sensor, 1])
        z = self.eyes[sensor, 2]
        direction, half = self.angles[sensor]
        direction += self.pose[2, owner]
        wedge = Point(x, y).buffer(_FAR)
        if half < math.pi:
            angles = np.linspace(direction - half, direction + half, 24)
            wedge = Polygon([(x, y), *((x + _FAR * math.cos(a), y + _FAR * math.sin(a)) for a in angles)])
        things = [
            Polygon([(row[0], row[1]) for row in self.walls.edges[first:end]])
            for (first, end, _), piece in zip(self.walls.links, self.walls.pieces, strict=True)
            if piece[4] <= z < piece[5]
        ]
        for part, row in enumerate(self.parts):
            if part // 2 != owner and row[4] <= z < row[5]:
                corners = [(row[0] + u * row[2], row[1] + v * row[3]) for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
                things.append(Polygon([self._to_world(part // 2, *corner) for corner in corners]))
        seen = shapely.intersection(things, wedge)
        distances = shapely.distance(Point(x, y), seen[~shapely.is_empty(seen)])
        return float(distances.min()) if len(distances) else math.inf

    def _to_world(self, body: int, u: float, v: float) -> tuple[float, float]:
        x, y, heading = self.pose[:, body]
        c, s = math.cos(heading), math.sin(heading)
        return x + c * u - s * v, y + s * u + c * v


def _ring(random: np.random.Generator, size: float) -> list[tuple[float, float]]:
    """Return a solid: a box that lies straight, a box that does not, or a star."""
    x, y = random.uniform(-size, size, 2)
    shape = random.integers(3)
    if shape == 0:
        a, b = random.uniform(0.1, 1.0, 2)
        return [(x, y), (x + a, y), (x + a, y + b), (x, y + b)]
    count = 4 if shape == 1 else 7
    turn = random.uniform(0, math.pi)
    radii = np.full(count, 0.5) if shape == 1 else random.uniform(0.2, 0.8, count)
    angles = turn + 2 * math.pi * np.arange(count) / count
    return [(x + r * math.cos(a), y + r * math.sin(a)) for a, r in zip(angles, radii, strict=True)]


@pytest.mark.parametrize(("seed", "bodies"), [(1, 1), (2, 2), (3, 9), (4, 30), (5, 60)])
def test_crowd_sees_what_geos_sees(seed: int, bodies: int) -> None:
    scene = _Scene(seed, bodies, sensors=4)
    statuses = set()
    for sensor, (status, distance) in enumerate(scene.seen()):
        expected = scene.by_geos(sensor)
        nearest, farthest = scene.eyes[sensor, 7], scene.eyes[sensor, 8]
        statuses.add(status)
        if expected > farthest:
            assert (status, distance) == (STATUS_NONE, 0.0)
        elif expected < nearest:
            assert (status, distance) == (STATUS_NEAR, 0.0)
        else:
            assert status == STATUS_OK
            assert distance == pytest.approx(expected, abs=1e-9)
    assert bodies < 30 or statuses == {STATUS_OK, STATUS_NONE, STATUS_NEAR}


def test_order_of_the_bodies_changes_no_bit_of_what_each_sees() -> None:
    scene = _Scene(6, 40, sensors=3)
    before = scene.seen().reshape(40, 3, 2)
    order = np.random.default_rng(7).permutation(40)
    scene.pose = np.ascontiguousarray(scene.pose[:, order])
    scene.parts = scene.parts.reshape(40, 2, 6)[order].reshape(80, 6)
    scene.eyes = scene.eyes.reshape(40, 3, 9)[order].reshape(120, 9)
    scene.stations = scene.stations[order]
    assert np.array_equal(scene.seen().reshape(40, 3, 2), before[order])


def test_floor_without_walls_and_world_without_sensors_are_no_trouble() -> None:
    scene = _Scene(8, 1, sensors=1)
    scene.walls = walls_from([])
    assert scene.seen().tolist() == [[STATUS_NONE, 0.0]]
    scene.crews = scene.crews[:0]
    assert np.isnan(scene.seen()).all()


def _seen_from(x: float, walls: Walls, *, farthest: float = 4.0, nearest: float = 0.05) -> list[float]:
    """Return what a sensor of 30 degrees, z 0.4, at (x, 0) sees straight ahead."""
    scene = _Scene(9, 1, sensors=1)
    scene.walls = walls
    scene.pose[:] = 0.0
    half = math.radians(15)
    scene.eyes[0] = x, 0.0, 0.4, 1.0, 0.0, math.cos(half), math.sin(half), nearest, farthest
    scene.stations[0, 3] = abs(x) + farthest
    return list(scene.seen()[0])


def test_too_close_nothing_there_and_a_distance_are_three_answers() -> None:
    wall = walls_from([Solid([(2.0, -1.0), (3.0, -1.0), (3.0, 1.0), (2.0, 1.0)], 0.0, 2.5)])
    assert _seen_from(0.0, wall) == [STATUS_OK, 2.0]
    assert _seen_from(1.96, wall) == [STATUS_NEAR, 0.0]
    assert _seen_from(2.5, wall, nearest=0.0) == [STATUS_NEAR, 0.0]
    assert _seen_from(4.0, wall) == [STATUS_NONE, 0.0]
    assert _seen_from(0.0, wall, farthest=2.0) == [STATUS_OK, 2.0]
    assert _seen_from(0.0, wall, farthest=1.999) == [STATUS_NONE, 0.0]


@pytest.mark.parametrize(
    ("bottom", "top", "seen"), [(0.4, 2.0, True), (0.0, 0.4, False), (0.0, 0.41, True), (0.5, 1.0, False)]
)
def test_z_range_holds_its_bottom_but_not_its_top(bottom: float, top: float, *, seen: bool) -> None:
    wall = walls_from([Solid([(2.0, -1.0), (3.0, -1.0), (3.0, 1.0), (2.0, 1.0)], bottom, top)])
    assert (_seen_from(0.0, wall)[0] == STATUS_OK) == seen
