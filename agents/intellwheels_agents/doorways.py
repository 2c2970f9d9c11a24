"""The doorways of a map: those that it declares, and narrow gaps between its walls; and the one that leads to a goal.

A gap is a free line of `NARROWEST` to `WIDEST` metres between two corners. A declared doorway may be wider. The frame
of a doorway has its origin in the middle of the opening and the x axis across it, towards the side of the goal. Pure.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

from intellwheels_agents.map_cells import Point, solids
from intellwheels_agents.portable_math import dist, sincos
from intellwheels_schemas.messages import Map

NARROWEST, WIDEST = 0.6, 1.3
"""Widths of gaps, m. Between walls farther apart, two people can pass each other."""
SAME = 0.6
"""Two gaps nearer to each other than this are the two sides of one doorway, m."""
BLOCKED = 0.3
"""A declared doorway with a wall or an obstacle nearer to its middle than this is no way, m."""
NEAR = 3.5
"""Walls up to this far from a doorway belong to it, m."""
SIGHT = 8.0
"""Farthest that a doorway is looked for, m."""

Edge = tuple[float, float, float, float]
"""x and y of both ends, m."""

_Cell = tuple[int, int]
_SIZE = 1.0
"""Edge of a cell, m: more than `SAME`."""
_BESIDE = 0.6
"""Walls farther than this from the middle of a gap do not block it, m."""
_PIECE = 2.0
_MOST_PIECES = 512
"""An edge is put into cells in pieces of at most `_PIECE` metres; one of more pieces counts everywhere."""


class Doorway(NamedTuple):
    """An opening that leads to the other side of a wall. Up to `WIDEST`, one person at a time can pass it.

    Attributes:
        x, y: Its middle, m.
        ux, uy: The unit vector across it, towards the side of the goal.
        width: From jamb to jamb, m.
        walls: The edges of walls near it.
    """

    x: float
    y: float
    ux: float
    uy: float
    width: float
    walls: tuple[Edge, ...]

    def local(self, x: float, y: float) -> Point:
        """Return a point of the map in the frame of the doorway, m."""
        x, y = x - self.x, y - self.y
        return x * self.ux + y * self.uy, y * self.ux - x * self.uy

    def on_map(self, x: float, y: float) -> Point:
        """Return a point in the frame of the doorway in that of the map, m."""
        return self.x + x * self.ux - y * self.uy, self.y + x * self.uy + y * self.ux


@lru_cache(maxsize=4)
def doorways(document: Map) -> tuple[tuple[Doorway, ...], tuple[Edge, ...]]:
    """Return the doorways of a map, whose x axes point either way, and the edges of its walls."""
    edges = wall_edges(document)
    corners = sorted({(x, y) for edge in edges for x, y in (edge[:2], edge[2:])})
    gaps: list[tuple[float, Point, Point]] = []
    for i, a in enumerate(corners):
        for b in corners[i + 1 :]:
            if b[0] - a[0] > WIDEST:
                break
            if NARROWEST <= dist(a, b) <= WIDEST:
                gaps.append((dist(a, b), a, b))
    gaps.sort()
    beside = _by_cell(edges)

    def is_free(x: float, y: float, metres: float) -> bool:
        return all(_distance(edge, x, y) >= metres for key in (_cell(x, y), None) for edge in beside.get(key, ()))

    def walls(x: float, y: float) -> tuple[Edge, ...]:
        return tuple(edge for edge in edges if _distance(edge, x, y) < NEAR)

    declared: list[Doorway] = []
    taken: dict[_Cell, list[Point]] = {}
    for each in document.doorway:
        x, y, width = each.x, each.y, each.width
        if width >= NARROWEST and is_free(x, y, min(0.45 * width, BLOCKED)):
            uy, ux = sincos(math.radians(each.heading_deg))
            declared.append(Doorway(x, y, ux, uy, width, walls(x, y)))
            taken.setdefault(_cell(x, y), []).append((x, y))
    found: list[Doorway] = []
    for width, a, b in gaps:
        x, y = middle = _middle(a, b)
        if any(dist(middle, other) < SAME for cell in _around(middle) for other in taken.get(cell, ())):
            continue
        if is_free(x, y, 0.45 * width):
            found.append(Doorway(x, y, (b[1] - a[1]) / width, (a[0] - b[0]) / width, width, walls(x, y)))
            taken.setdefault(_cell(x, y), []).append(middle)
    return (*declared, *_between_both_sides(found, gaps)), edges


def _between_both_sides(found: list[Doorway], gaps: list[tuple[float, Point, Point]]) -> Iterator[Doorway]:
    """Yield the doorways, with the middle between the gaps of both faces of the wall."""
    middles: dict[_Cell, list[tuple[float, Point]]] = {}
    for width, a, b in gaps:
        middle = _middle(a, b)
        middles.setdefault(_cell(*middle), []).append((width, middle))
    for one in found:
        near = [both for cell in _around((one.x, one.y)) for both in middles.get(cell, ())]
        places = [one.local(*middle) for width, middle in near if width < one.width + 1e-3]
        alongs = [x for x, y in places if abs(x) < SAME and abs(y) < 0.05]
        half = math.fsum(alongs) / len(alongs)
        yield one._replace(x=one.x + half * one.ux, y=one.y + half * one.uy)


def _middle(a: Point, b: Point) -> Point:
    return (a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0


def _cell(x: float, y: float) -> _Cell:
    return math.floor(x / _SIZE), math.floor(y / _SIZE)


def _around(point: Point) -> Iterator[_Cell]:
    """Yield the cell of a point and those around it: all that is nearer than a cell is in one of them."""
    column, row = _cell(*point)
    return ((column + i, row + j) for i in (-1, 0, 1) for j in (-1, 0, 1))


def _by_cell(edges: Sequence[Edge]) -> dict[_Cell | None, list[Edge]]:
    """Return the edges that are nearer than `_BESIDE` to a point of each cell, at least; under None, very long ones."""
    found: dict[_Cell | None, list[Edge]] = {}
    for edge in edges:
        ax, ay, bx, by = edge
        pieces = math.ceil(max(abs(bx - ax), abs(by - ay)) / _PIECE) or 1
        keys: set[_Cell | None] = set() if pieces <= _MOST_PIECES else {None}
        for piece in range(pieces if not keys else 0):
            ends = piece / pieces, (piece + 1) / pieces
            xs, ys = ([low + end * (high - low) for end in ends] for low, high in ((ax, bx), (ay, by)))
            first, last = _cell(min(xs) - _BESIDE, min(ys) - _BESIDE), _cell(max(xs) + _BESIDE, max(ys) + _BESIDE)
            keys.update((i, j) for i in range(first[0], last[0] + 1) for j in range(first[1], last[1] + 1))
        for key in keys:
            found.setdefault(key, []).append(edge)
    return found


def wall_edges(document: Map) -> tuple[Edge, ...]:
    """Return the edges of all walls and obstacles that a person can meet, m."""
    return tuple(
        (*a, *b) for ring in solids(document) for a, b in zip(ring, (*ring[1:], ring[0]), strict=True) if a != b
    )


def way_through(doors: Sequence[Doorway], edges: Sequence[Edge], here: Point, goal: Point) -> Doorway | None:
    """Return the doorway that leads from a point to a goal, or None if none is needed or none is seen.

    It is the nearest one that the straight way passes, or in which the goal is. If a wall is in the straight way, it is
    the one with the shortest way of those that are seen and have the goal on their other side.

    Args:
        doors: The doorways of the map.
        edges: The edges of all its walls.
        here: Where the pedestrian is, m.
        goal: Where it walks to, m.
    """
    best: Doorway | None = None
    least = math.inf
    blocked: bool | None = None
    for one in doors:
        away = dist(here, (one.x, one.y))
        if away > SIGHT:
            continue
        from_x, from_y = one.local(*here)
        to_x, to_y = one.local(*goal)
        inside = max(abs(to_x), abs(to_y)) < min(one.width, WIDEST) / 2.0
        if inside:
            to_x = -from_x
        if from_x * to_x >= 0.0 or (abs(to_x) < 0.3 and not inside):
            continue
        across = from_y - (to_y - from_y) * from_x / (to_x - from_x)
        if inside or abs(across) < one.width / 2.0:
            cost = away
        else:
            if blocked is None:
                blocked = _crossed(edges, here, goal)
            if not blocked:
                continue
            cost = 1e3 + away + dist((one.x, one.y), goal)
        if cost < least and not _crossed(one.walls, here, (one.x, one.y)):
            turned = one if to_x > 0.0 else one._replace(ux=-one.ux, uy=-one.uy)
            best, least = turned, cost
    return best


def near_wall(walls: Sequence[Edge], x: float, y: float, metres: float) -> bool:
    """Return whether a point is within some metres of a wall."""
    return any(_distance(edge, x, y) < metres for edge in walls)


def _distance(edge: Edge, x: float, y: float) -> float:
    """Return the distance of a point from an edge, m."""
    ax, ay, bx, by = edge
    dx, dy, x, y = bx - ax, by - ay, x - ax, y - ay
    square = dx * dx + dy * dy  # 0 for a tiny edge, too
    share = min(max((x * dx + y * dy) / square, 0.0), 1.0) if square > 0.0 else 0.0
    x, y = x - share * dx, y - share * dy
    return math.sqrt(x * x + y * y)


def _crossed(edges: Sequence[Edge], a: Point, b: Point) -> bool:
    """Return whether the line between two points crosses an edge."""
    (x, y), dx, dy = a, b[0] - a[0], b[1] - a[1]
    for ax, ay, bx, by in edges:
        first, second = dx * (ay - y) - dy * (ax - x), dx * (by - y) - dy * (bx - x)
        if first * second <= 0.0:
            ex, ey = bx - ax, by - ay
            if (ex * (y - ay) - ey * (x - ax)) * (ex * (y + dy - ay) - ey * (x + dx - ax)) <= 0.0:
                return True
    return False
