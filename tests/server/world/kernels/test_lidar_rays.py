"""What lidars meet, ray by ray against GEOS, and what goes wrong."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import shapely
from shapely.geometry import LineString, Point, Polygon

from intellwheels_schemas.file_records import TeleportBody
from intellwheels_schemas.messages import Corner, Lidar, LidarReading, Position, Wall
from intellwheels_server.world import State, measures
from tests.server.worlds import ROUNDED, box_wall, cart, do, world


def _lidar(**fields: Any) -> Lidar:
    known: dict[str, Any] = {
        "id": "l", "x": 0.3, "y": 0.1, "z": 0.4, "direction_deg": 20.0, "fov_deg": 270.0, "rays": 61, "max_range": 8.0,
    }  # fmt: skip
    return Lidar(**{**known, **fields})


def _scan(state: State, agent: str = "a") -> LidarReading:
    sensors = measures(state, agent).sensors
    assert sensors is not None
    return sensors.lidar[0]


def _star(random: np.random.Generator, x: float, y: float) -> Wall:
    angles = random.uniform(0, 7) + 2 * math.pi * np.arange(7) / 7
    radii = random.uniform(0.2, 0.8, 7)
    return Wall(
        corner=tuple(Corner(x=x + r * math.cos(a), y=y + r * math.sin(a)) for a, r in zip(angles, radii, strict=True))
    )


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_ranges_are_those_of_geos(seed: int) -> None:
    random = np.random.default_rng(seed)
    spots = [(2.5 * i, 2.5 * k) for i in range(6) for k in range(6)]
    robots, walls = {}, []
    for at, (x, y) in enumerate(spots):
        if at % 3 == 0:
            walls.append(_star(random, x, y))
        elif at % 3 == 1:
            walls.append(box_wall(x - 0.1, y - 0.5, x + 0.4, y + 0.3))
        else:
            robots[f"r{at}"] = cart(x, y, random.uniform(-3, 3), lidar=(_lidar(),))
    state = world(robots, walls)
    solids = [Polygon([(corner.x, corner.y) for corner in wall.corner]) for wall in walls]
    frames = {name: state.numbers[:3, state.body_set.index[name]] for name in robots}
    box = [(0.5, 0.3), (-0.5, 0.3), (-0.5, -0.3), (0.5, -0.3)]
    bodies = {name: Polygon([_out(frame, *corner) for corner in box]) for name, frame in frames.items()}
    met = 0
    for name, frame in frames.items():
        eye = Point(_out(frame, 0.3, 0.1))
        others = shapely.union_all([*solids, *(body for other, body in bodies.items() if other != name)])
        scan = _scan(state, name)
        assert (scan.start_deg, scan.step_deg, scan.stamp, len(scan.ranges)) == (-115.0, 4.5, 0.0, 61)
        for ray, (told, status) in enumerate(zip(scan.ranges, scan.statuses, strict=True)):
            angle = frame[2] + math.radians(scan.start_deg + ray * scan.step_deg)
            line = LineString([eye, (eye.x + 8.0 * math.cos(angle), eye.y + 8.0 * math.sin(angle))])
            cut = shapely.intersection(line, others)
            if cut.is_empty:
                assert (told, status) == (None, "none")
            else:
                assert status == "ok"
                assert told == pytest.approx(shapely.distance(eye, cut), abs=ROUNDED)
                met += 1
    assert met > 300


def _out(frame: Any, u: float, v: float) -> tuple[float, float]:
    x, y, heading = frame
    c, s = math.cos(heading), math.sin(heading)
    return float(x + c * u - s * v), float(y + s * u + c * v)


def test_near_far_and_another_height_are_different_answers() -> None:
    walls = [box_wall(1.3, -1, 2, 1)]
    one: dict[str, Any] = {"rays": 1, "direction_deg": 0.0, "y": 0.0}
    assert _scan(world({"a": cart(lidar=(_lidar(min_range=1.1, **one),))}, walls)).statuses == ("near",)
    assert _scan(world({"a": cart(lidar=(_lidar(max_range=0.9, **one),))}, walls)).statuses == ("none",)
    assert _scan(world({"a": cart(lidar=(_lidar(z=3.0, **one),))}, walls)).statuses == ("none",)
    inside = world({"a": cart(lidar=(_lidar(x=1.5, y=0.0, rays=1),))}, walls)
    assert _scan(inside).statuses == ("near",)


def _errors(distance: float, **fields: Any) -> list[float]:
    lidar = _lidar(x=0.0, y=0.0, fov_deg=1e-9, rays=1000, direction_deg=0.0, **fields)
    scan = _scan(world({"a": cart(lidar=(lidar,))}, [box_wall(distance, -1, distance + 1, 1)]))
    return [told - distance for told in scan.ranges if told is not None]


def test_noise_is_the_larger_of_the_least_and_the_share() -> None:
    # Four standard errors of 1000 draws.
    assert np.std(_errors(1.0, noise=0.01, noise_share=0.005)) == pytest.approx(0.01, rel=0.09)
    assert np.std(_errors(6.0, noise=0.01, noise_share=0.005)) == pytest.approx(0.03, rel=0.09)
    assert len(_errors(2.0, dropout=0.3)) == pytest.approx(700, abs=60)


def test_ray_that_grazes_a_wall_is_lost() -> None:
    for turned, returns in ((59.0, True), (61.0, False)):
        lidar = _lidar(x=0.0, y=0.0, rays=1, direction_deg=0.0, incidence_deg=60.0)
        state = world({"a": cart(lidar=(lidar,))}, [box_wall(1.0, -9, 2, 9)])
        position = Position(x=0.0, y=0.0, heading=math.radians(turned))
        state, _, _ = do(state, TeleportBody(agent="a", position=position, force=True))
        assert (_scan(state).ranges[0] is not None) == returns
        slanted = Wall(corner=tuple(Corner(x=x, y=y) for x, y in ((1.0, -9.0), (1.0, 9.0), (9.0, 0.0))))
        state = world({"a": cart(heading=math.radians(turned), lidar=(lidar,))}, [slanted])
        assert (_scan(state).ranges[0] is not None) == returns
