"""Warns of places at which a robot cannot turn on the spot. Pure: documents in, findings out.

A robot turns around its centre of movement, so each of its parts needs a free circle as large as its farthest corner.
A place that is too narrow is no error: a robot may leave it as it came. A mind that does not know it may stand there
for ever.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

from intellwheels_maps.check import Finding, ring_of, wall_pieces
from intellwheels_maps.crossing import Point
from intellwheels_maps.plane_geometry import bounds, contains, edges
from intellwheels_schemas.messages import Map, Place, Robot, Scene
from intellwheels_schemas.rules import is_mobile, parts_of


def narrow_places(floor: Map, robots: Mapping[str, Robot]) -> list[Finding]:
    """Return the places of a map that are too narrow for a robot to turn at.

    A place counts for the robots whose kind it names, or for all if it names none. A goal counts for wheelchairs.

    Args:
        floor: The map.
        robots: The robots, by the name that the text gives.
    """
    findings = []
    solids = list(_solids(floor))
    circles = {name: _circles(robot) for name, robot in robots.items()}
    reach = _reach(*circles.values())
    for index, place in enumerate(floor.grid.position if floor.grid else ()):
        near = [solid for solid in solids if _may_meet(solid, place.x, place.y, reach)]
        for name, robot in robots.items():
            serves = not place.kinds or robot.kind in place.kinds
            goal = robot.kind == "wheelchair" and "goal" in place.kinds
            why = _why(circles[name], near, place.x, place.y) if serves or goal else None
            if why is not None:
                text = f"place {place.name!r} is too narrow for {name!r}: {why}"
                findings.append(Finding(f"Map.Grid.Position[{index}]", text))
    return findings


def narrow_starts(scene: Scene, floor: Map, robots: Mapping[str, Robot]) -> list[Finding]:
    """Return which agents of a scene start where they cannot turn.

    Args:
        scene: The scene.
        floor: Its map.
        robots: The body of each agent, by name. Others are not checked, nor are the leaves of doors.
    """
    places: dict[str | None, Place] = {place.name: place for place in floor.grid.position} if floor.grid else {}
    findings = []
    check = TurningCheck(floor)
    for index, cast in enumerate(scene.cast):
        if cast.name in robots and robots[cast.name].kind != "door" and cast.place in places:
            place = places[cast.place]
            why = check.narrowness(robots[cast.name], place.x, place.y)
            if why is not None:
                text = f"agent {cast.name!r}: place {place.name!r} is too narrow: {why}"
                findings.append(Finding(f"Scene.Cast[{index}]", text))
    return findings


_CELL = 8.0
"""Size of the squares in which solids are looked up, m."""
_LARGE = 1000.0
"""Length in m, or area in m2, of solids that are not looked up: they would be in many squares."""


class TurningCheck:
    """Tells where robots cannot turn on one map. It cuts the walls once, which takes longer than all else here.

    Attributes:
        floor: The map.
    """

    def __init__(self, floor: Map) -> None:
        self.floor = floor
        self._solids = list(_solids(floor))
        self._cells: dict[tuple[int, int], list[int]] = {}  # the solids whose bounds meet each square
        self._large: list[int] = []  # those that meet many
        for number, solid in enumerate(self._solids):
            left, right, below, above = solid[4]
            if (right - left) * (above - below) > _LARGE or max(right - left, above - below) > _LARGE:
                self._large.append(number)
                continue
            for cell in _squares(*solid[4]):
                self._cells.setdefault(cell, []).append(number)

    def narrowness(self, robot: Robot, x: float, y: float) -> str | None:
        """Return why a robot cannot turn on the spot at a point of the map, or None if it can or never turns.

        Args:
            robot: The robot. One without motors, or on a hinge, never turns on the spot.
            x: The point, m.
            y: The point, m.
        """
        circles = _circles(robot)
        reach = _reach(circles)
        near = set(self._large)
        for cell in _squares(x - reach, x + reach, y - reach, y + reach):
            near.update(self._cells.get(cell, ()))
        solids = (self._solids[number] for number in sorted(near))
        return _why(circles, (solid for solid in solids if _may_meet(solid, x, y, reach)), x, y)


def _squares(left: float, right: float, below: float, above: float) -> Iterator[tuple[int, int]]:
    """Yield the squares that some bounds meet."""
    rows = range(math.floor(below / _CELL), math.floor(above / _CELL) + 1)
    for column in range(math.floor(left / _CELL), math.floor(right / _CELL) + 1):
        for row in rows:
            yield column, row


Circle = tuple[float, float, float]
"""What a part of a robot sweeps as it turns: radius, lower and upper end, m."""
Solid = tuple[str, list[Point], float, float, tuple[float, float, float, float]]
"""What stands on the map: its name, corners, lower and upper end, and the bounds of x and of y, m."""


def _circles(robot: Robot) -> list[Circle]:
    if not is_mobile(robot):
        return []
    return [
        (math.hypot(abs(part.x) + part.length / 2.0, abs(part.y) + part.width / 2.0), part.bottom, part.top)
        for part in parts_of(robot)
    ]


def _reach(*several: Iterable[Circle]) -> float:
    return max((radius for circles in several for radius, _, _ in circles), default=0.0)


def _solids(floor: Map) -> Iterator[Solid]:
    for index, wall in enumerate(floor.wall):
        for piece in wall_pieces(wall):
            yield f"Wall[{index}]", piece, wall.bottom, wall.height, bounds(piece)
    for obstacle in floor.obstacle:
        ring = ring_of(obstacle.corner)
        yield f"obstacle {obstacle.name!r}", ring, obstacle.bottom, obstacle.top, bounds(ring)


def _may_meet(solid: Solid, x: float, y: float, reach: float) -> bool:
    left, right, below, above = solid[4]
    return left - x < reach and x - right < reach and below - y < reach and y - above < reach


def _why(circles: Iterable[Circle], solids: Iterable[Solid], x: float, y: float) -> str | None:
    worst: tuple[float, float, float, str] | None = None
    for what, corners, bottom, top, _ in solids:
        way = _distance(corners, x, y)
        for radius, low, high in circles:
            if low < top and bottom < high and (worst is None or radius - way > worst[0]):
                worst = radius - way, radius, way, what
    if worst is None or worst[0] <= 0.0:
        return None
    _, radius, way, what = worst
    return f"it needs {radius:.3f} m to turn on the spot, got {way:.3f} m to {what}"


def _distance(corners: list[Point], x: float, y: float) -> float:
    """Return the distance from a point to a polygon, m; 0 inside."""
    if contains(corners, (x, y)):
        return 0.0
    nearest = math.inf
    for (ax, ay), (bx, by) in edges(corners):
        dx, dy = bx - ax, by - ay
        share = min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)))
        nearest = min(nearest, math.hypot(ax + share * dx - x, ay + share * dy - y))
    return nearest
