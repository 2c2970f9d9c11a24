"""The shortest way around the walls of a map, for a pedestrian who knows the building.

The corners of the walls, moved away from them by `CLEARANCE`, and the straight lines between them that keep `NARROW`
from all walls make a visibility graph; A* finds the shortest way in it. A line is checked only when it is needed.

Source: T. Lozano-Perez, M. Wesley, An algorithm for planning collision-free paths among polyhedral obstacles,
Communications of the ACM 22, 1979 (visibility graph).
"""

from __future__ import annotations

import heapq
import math

from intellwheels_agents.portable_math import dist, hypot
from intellwheels_agents.pure_pursuit import Point
from intellwheels_schemas.messages import Map, Wall

CLEARANCE = 0.35
"""Distance of the corners of a way from the surface of a wall, m (chosen: the radius of a person is 0.31 m)."""
NARROW = 0.27
"""Least distance of a way from a wall, m (chosen: half of a person's width and 2 cm)."""
SEEN = 0.2
"""The same for a corner that a walker may cut because the next one is in sight, m (chosen)."""
BESIDE = 0.7
"""Distance of walls on both sides of a narrow passage, m (chosen: two people abreast need more than 1 m)."""
IN = 0.5
"""Distance from the middle of a passage within which a line leads through it, m (chosen)."""
OPPOSITE = -0.5
"""Cosine of the angle between two directions below which they are opposite (chosen)."""
ON_WALL = 0.06
"""Distance within which a point counts as on a wall, m (chosen)."""
DIAGONAL = 0.8
"""Length of the bends beside the end of a wall, as a share of those beyond it along both axes (chosen)."""
ROUNDING = 0.01
"""Distance that does not matter, m (chosen)."""
HEAD = 1.75
"""Walls whose lower edge is higher than this do not count, m: the height of a person."""

_Segment = tuple[float, float, float, float, float]


class WalkingRoute:
    """The walls of a map, and the ways around them."""

    def __init__(self, document: Map) -> None:
        """Take the map."""
        self._segments: list[_Segment] = []
        nodes: list[Point] = []
        for wall in document.wall:
            if wall.bottom < HEAD:
                self._segments += _segments(wall)
                nodes += _corners(wall)
        self._nodes = [node for node in nodes if self.clear(node, node, NARROW)]
        self._passages = [node for node in self._nodes if self._narrow(node)]

    def clear(self, a: Point, b: Point, least: float) -> bool:
        """Return whether all of a line keeps a distance (m) from the surfaces of all walls."""
        low_x, high_x = min(a[0], b[0]), max(a[0], b[0])
        low_y, high_y = min(a[1], b[1]), max(a[1], b[1])
        for x, y, x2, y2, half in self._segments:
            reach = least + half
            if (
                min(x, x2) - reach < high_x
                and max(x, x2) + reach > low_x
                and min(y, y2) - reach < high_y
                and max(y, y2) + reach > low_y
                and _apart(a, b, (x, y), (x2, y2)) < reach
            ):
                return False
        return True

    def on_wall(self, point: Point) -> bool:
        """Return whether a point is on the surface of a wall, within `ON_WALL`."""
        return not self.clear(point, point, ON_WALL)

    def passage(self, here: Point, there: Point, reach: float) -> Point | None:
        """Return the nearest narrow passage that a straight line leads through within a reach (m), None if none."""
        near = [one for one in self._passages if dist(one, here) < reach]
        through = [one for one in near if dist(one, _nearest(one, here, there)) < IN]
        return min(through, key=lambda one: dist(one, here), default=None)

    def _narrow(self, point: Point) -> bool:
        """Return whether walls on opposite sides of a point leave only room for one: nearer than `BESIDE` each."""
        units: list[Point] = []
        for x, y, x2, y2, half in self._segments:
            near_x, near_y = _nearest(point, (x, y), (x2, y2))
            off_x, off_y = near_x - point[0], near_y - point[1]
            away = hypot(off_x, off_y)
            if 0.0 < away < BESIDE + half:
                units.append((off_x / away, off_y / away))
        return any(a[0] * b[0] + a[1] * b[1] < OPPOSITE for a in units for b in units)

    def _room(self, point: Point) -> float:
        """Return the distance of a point from the surface of the nearest wall, m."""
        return min(
            (dist(point, _nearest(point, (x, y), (x2, y2))) - half for x, y, x2, y2, half in self._segments),
            default=math.inf,
        )

    def way(self, start: Point, goal: Point) -> list[Point]:
        """Return the corners of the shortest way, the goal last, or the goal alone if there is none."""
        if self.clear(start, goal, SEEN):
            return [goal]
        # A way may start or end nearer to a wall than it keeps elsewhere.
        at_start, at_end = (min(NARROW, max(self._room(end) - ROUNDING, ROUNDING)) for end in (start, goal))
        points = [start, *self._nodes, goal]
        last = len(points) - 1
        costs = {0: 0.0}
        before: dict[int, int] = {}
        done: set[int] = set()
        # Entries: expected length of the whole way, length so far, the corner, the one before it.
        heap: list[tuple[float, float, int, int]] = [(dist(start, goal), 0.0, 0, 0)]
        while heap:
            _, cost, i, previous = heapq.heappop(heap)
            if i in done:
                continue
            least = min(at_start if previous == 0 else NARROW, at_end if i == last else NARROW)
            if i and not self.clear(points[previous], points[i], least):
                continue
            done.add(i)
            before[i], costs[i] = previous, cost
            if i == last:
                found = []
                while i:
                    found.append(points[i])
                    i = before[i]
                return found[::-1]
            for j in range(1, last + 1):
                if j not in done:
                    so_far = cost + dist(points[i], points[j])
                    heapq.heappush(heap, (so_far + dist(points[j], goal), so_far, j, i))
        return [goal]


def _segments(wall: Wall) -> list[_Segment]:
    """Return the lines of a wall: both ends and half of the thickness, m."""
    corners = [(one.x, one.y) for one in wall.corner]
    half = 0.0 if wall.thickness is None else wall.thickness / 2.0
    ends = corners[1:] if wall.thickness is not None else corners[1:] + corners[:1]
    return [(*a, *b, half) for a, b in zip(corners, ends, strict=False)]


def _corners(wall: Wall) -> list[Point]:
    """Return the points beside the corners of a wall where a way may bend: on both sides of a bend, around an end."""
    corners = [(one.x, one.y) for one in wall.corner]
    count = len(corners)
    closed = wall.thickness is None or corners[0] == corners[-1]
    if closed and corners[0] == corners[-1]:
        corners.pop()
        count -= 1
    off = CLEARANCE + (0.0 if wall.thickness is None else wall.thickness / 2.0)
    found: list[Point] = []
    for i, (x, y) in enumerate(corners):
        units = []
        for j in (i - 1, i + 1):
            if closed or 0 <= j < count:
                other = corners[j % count]
                length = max(dist((x, y), other), 1e-9)
                units.append(((x - other[0]) / length, (y - other[1]) / length))
        along_x, along_y = sum(unit[0] for unit in units), sum(unit[1] for unit in units)
        length = hypot(along_x, along_y)
        if length > 0.05:
            # Along the bisector of a bend, so that the way is as far from both sides as from the end of a wall.
            slant = 1.0 if len(units) == 1 else max(math.sqrt(max(1.0 - length * length / 4.0, 0.0)), 0.5)
            share = off / (slant * length)
            along_x, along_y = share * along_x, share * along_y
            found += [(x + along_x, y + along_y), (x - along_x, y - along_y)]
            if len(units) == 1:
                for side in (-1.0, 1.0):
                    across_x, across_y = -side * along_y, side * along_x
                    found.append((x + across_x, y + across_y))
                    found.append((x + DIAGONAL * (along_x + across_x), y + DIAGONAL * (along_y + across_y)))
    return found


def _apart(a: Point, b: Point, c: Point, d: Point) -> float:
    """Return the distance of two straight lines between points, m; 0 if they cross."""
    if _side(a, b, c) * _side(a, b, d) < 0.0 and _side(c, d, a) * _side(c, d, b) < 0.0:
        return 0.0
    return min(dist(p, _nearest(p, *line)) for p, line in ((a, (c, d)), (b, (c, d)), (c, (a, b)), (d, (a, b))))


def _side(a: Point, b: Point, p: Point) -> float:
    """Return a number whose sign says on which side of a line a point is."""
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])


def _nearest(p: Point, a: Point, b: Point) -> Point:
    """Return the point of the line between two points that is nearest to a point."""
    x, y = b[0] - a[0], b[1] - a[1]
    square = x * x + y * y
    share = 0.0 if square == 0.0 else min(max(((p[0] - a[0]) * x + (p[1] - a[1]) * y) / square, 0.0), 1.0)
    return a[0] + share * x, a[1] + share * y
