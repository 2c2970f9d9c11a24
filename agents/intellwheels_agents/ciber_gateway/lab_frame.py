"""A map as a lab of the Ciber-Rato simulator: a rectangle with walls, beacons, targets and a grid of starts. Pure.

A unit of a lab is the diameter of that simulator's robot, and 1 m here, as the importer of labs has it. The lab begins
at the inner corner of the map's border, where the coordinates of an imported lab are 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from intellwheels_maps.check import points_of, ring_of, wall_pieces
from intellwheels_schemas.messages import Map, Place, Wall

BEACON: Final = "beacon"
"""Kind of the places that are beacons."""
KIND: Final = "robot"
"""Kind of the robots."""
_NEAR: Final = 1e-6

Point = tuple[float, float]


@dataclass(frozen=True)
class Solid:
    """A wall of a lab: its height and its corners in lab coordinates, m."""

    height: float
    corners: tuple[Point, ...]


@dataclass(frozen=True)
class Target:
    """A target of a lab: the zone, and the circle around it in lab coordinates, m."""

    zone: str
    x: float
    y: float
    radius: float


@dataclass(frozen=True)
class Lab:
    """A lab.

    Attributes:
        name: Its title.
        west, south: Where it begins, in the map frame, m.
        width, height: Its size, m.
        walls: All that is solid, without the border.
        beacons: The places that are beacons.
        targets: The zones of the map, in its order.
        starts: Where robots start, in the order of the grid.
    """

    name: str
    west: float
    south: float
    width: float
    height: float
    walls: tuple[Solid, ...]
    beacons: tuple[Place, ...]
    targets: tuple[Target, ...]
    starts: tuple[Place, ...]

    def target_number(self, zone: str | None) -> int:
        """Return the number of the target that is a zone, from 0, or -1."""
        return next((index for index, target in enumerate(self.targets) if target.zone == zone), -1)


def lab_of(document: Map) -> Lab:
    """Return a map as a lab."""
    border = next((wall for wall in document.wall if _is_border(wall, document)), None)
    rings = [(wall.height, ring) for wall in document.wall if wall is not border for ring in wall_pieces(wall)]
    rings += [(obstacle.top, ring_of(obstacle.corner)) for obstacle in document.obstacle]
    places = () if document.grid is None else document.grid.position
    if border is not None:
        half = (border.thickness or 0.0) / 2
        west, south, east, north = _box(points_of(border.corner))
        west, south, east, north = west + half, south + half, east - half, north - half
    else:
        west, south, east, north = _box([*_points(document), *((place.x, place.y) for place in places)] or [(0.0, 0.0)])
    walls = tuple(Solid(height, tuple((x - west, y - south) for x, y in ring)) for height, ring in rings)
    targets = []
    for zone in document.zone:
        points = points_of(zone.corner)
        a, b, c, d = _box(points)
        x, y = (a + c) / 2, (b + d) / 2
        targets.append(Target(zone.name, x - west, y - south, max(math.dist((x, y), point) for point in points)))
    return Lab(
        name=document.title or document.name,
        west=west,
        south=south,
        width=max(east - west, 1.0),
        height=max(north - south, 1.0),
        walls=walls,
        beacons=tuple(place for place in places if BEACON in place.kinds),
        targets=tuple(targets),
        starts=tuple(place for place in places if not place.kinds or KIND in place.kinds),
    )


def _is_border(wall: Wall, document: Map) -> bool:
    """Return whether a wall is a closed rectangular line around all others."""
    points = points_of(wall.corner)
    if wall.thickness is None or len(points) != 5 or math.dist(points[0], points[-1]) > _NEAR:
        return False
    west, south, east, north = _box(points)
    if any(x not in (west, east) or y not in (south, north) for x, y in points):
        return False
    reach = wall.thickness / 2 + _NEAR
    return all(
        west - reach <= x <= east + reach and south - reach <= y <= north + reach for x, y in _points(document)
    )  # fmt: skip


def _points(document: Map) -> list[Point]:
    return [point for wall in document.wall for ring in wall_pieces(wall) for point in ring]


def _box(points: Sequence[Point]) -> tuple[float, float, float, float]:
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return min(xs), min(ys), max(xs), max(ys)
