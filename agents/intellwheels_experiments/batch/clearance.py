"""Room around a body and the shortest way on a floor. Pure: floors, robots and poses in, metres out."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from intellwheels_experiments.batch.metrics import Floats
from intellwheels_maps.check import wall_pieces
from intellwheels_schemas.messages import Map, Part, Robot
from intellwheels_schemas.rules import parts_of

Geometries = NDArray[Any]


def clearance(poses: Floats, robot: Robot, floor: Map, others: Mapping[str, tuple[Robot, Floats]]) -> Floats:
    """Return metres between a body and what is nearest to it at each tick, float64[n]; 0 where they touch.

    Only what shares a height with a part of it counts.

    Args:
        poses: float64[n, 3], of the body.
        robot: The body.
        floor: Its walls and obstacles count.
        others: The other bodies by name: robot and poses, NaN where one is not there.
    """
    found = np.full(len(poses), math.inf)
    for part in parts_of(robot):
        shape = _placed(part, poses)
        solid = [piece for bottom, top, piece in _solids(floor) if _meet(part.bottom, part.top, bottom, top)]
        if solid:
            found = np.minimum(found, shapely.distance(shape, shapely.union_all(solid)))
        for other, at in others.values():
            for their in parts_of(other):
                if _meet(part.bottom, part.top, their.bottom, their.top):
                    found = np.fmin(found, shapely.distance(shape, _placed(their, at)))
    return found


def shortest_way(floor: Map, start: tuple[float, float], goal: tuple[float, float], room: float) -> float:
    """Return the length of the shortest way between two points that keeps a distance from all that is solid, m.

    It is inf where there is none. Bodies do not count, and doors are open.

    Args:
        floor: The floor.
        start: Where from.
        goal: Where to.
        room: Half the width of who goes, m.
    """
    # A little less than the room, so that a start that just fits is free.
    blocked = shapely.union_all([shapely.buffer(piece, room - 1e-6, quad_segs=8) for _, _, piece in _solids(floor)])
    shapely.prepare(blocked)
    inner = shapely.buffer(blocked, -1e-6)
    shapely.prepare(inner)
    corners = shapely.get_coordinates(blocked)
    points = [start, goal, *map(tuple, np.unique(corners, axis=0).tolist())]
    pairs = [(i, j) for i, j in itertools.combinations(range(len(points)), 2)]
    ends = np.array([[points[i], points[j]] for i, j in pairs])
    free = ~shapely.intersects(inner, shapely.linestrings(ends))
    lengths = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    rows, columns = np.array(pairs).T
    graph: Any = csr_array((lengths[free], (rows[free], columns[free])), shape=(len(points), len(points)))
    found: Any = dijkstra(graph, directed=False, indices=[0])
    return float(found[0, 1])


def half_width(robot: Robot) -> float:
    """Return how far a body reaches to its wider side, m."""
    return max(abs(part.y) + part.width / 2.0 for part in parts_of(robot))


def _solids(floor: Map) -> Iterable[tuple[float, float, Any]]:
    for wall in floor.wall:
        for piece in wall_pieces(wall):
            yield wall.bottom, wall.height, shapely.polygons(piece)
    for obstacle in floor.obstacle:
        yield obstacle.bottom, obstacle.top, shapely.polygons([(corner.x, corner.y) for corner in obstacle.corner])


def _meet(bottom: float, top: float, other_bottom: float, other_top: float) -> bool:
    return bottom < other_top and other_bottom < top


def _placed(part: Part, poses: Floats) -> Geometries:
    """Return a part at each pose as a polygon; missing where the pose is NaN."""
    corners = np.array(_corners(part))
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    x = poses[:, 0][:, None] + c * corners[:, 0] - s * corners[:, 1]
    y = poses[:, 1][:, None] + s * corners[:, 0] + c * corners[:, 1]
    there = np.isfinite(poses).all(axis=1)
    found: Geometries = np.full(len(poses), None, dtype=object)
    found[there] = shapely.polygons(np.stack([x, y], axis=2)[there])
    return found


def _corners(part: Part) -> Sequence[tuple[float, float]]:
    along, across = part.length / 2.0, part.width / 2.0
    return [(part.x + a * along, part.y + b * across) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
