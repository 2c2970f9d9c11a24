"""Clearance around a body, and the shortest path on a map. Pure: maps, robots and poses in, metres out."""

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
    """Return the distance from a body to the nearest thing at each tick, float64[n], in m; 0 where they touch.

    Only things that overlap a part of the body in height count.

    Args:
        poses: The body's poses, float64[n, 3]: x and y in m, heading in rad.
        robot: The body.
        floor: The map, for its walls and obstacles.
        others: The other bodies by name: robot and poses, NaN where a body is absent.
    """
    distance = np.full(len(poses), math.inf)
    for part in parts_of(robot):
        shape = _polygons(part, poses)
        solids = [piece for bottom, top, piece in _solids(floor) if _overlap(part.bottom, part.top, bottom, top)]
        if solids:
            distance = np.minimum(distance, shapely.distance(shape, shapely.union_all(solids)))
        for other, other_poses in others.values():
            for other_part in parts_of(other):
                if _overlap(part.bottom, part.top, other_part.bottom, other_part.top):
                    distance = np.fmin(distance, shapely.distance(shape, _polygons(other_part, other_poses)))
    return distance


def shortest_path(floor: Map, start: tuple[float, float], goal: tuple[float, float], margin: float) -> float:
    """Return the length of the shortest path between two points, in m; inf where there is none.

    The path keeps `margin` from walls and obstacles. Other bodies do not count, and doors are open.

    Args:
        floor: The map.
        start: x and y in m.
        goal: x and y in m.
        margin: Half the width of the body that drives, in m.
    """
    # Slightly less than the margin, so that a start that just fits counts as free.
    blocked = shapely.union_all([shapely.buffer(piece, margin - 1e-6, quad_segs=8) for _, _, piece in _solids(floor)])
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
    lengths_from_start: Any = dijkstra(graph, directed=False, indices=[0])
    return float(lengths_from_start[0, 1])


def half_width(robot: Robot) -> float:
    """Return how far a body extends to its wider side, in m."""
    return max(abs(part.y) + part.width / 2.0 for part in parts_of(robot))


def _solids(floor: Map) -> Iterable[tuple[float, float, Any]]:
    for wall in floor.wall:
        for piece in wall_pieces(wall):
            yield wall.bottom, wall.height, _polygon(piece)
    for obstacle in floor.obstacle:
        yield obstacle.bottom, obstacle.top, _polygon([(corner.x, corner.y) for corner in obstacle.corner])


def _polygon(ring: Sequence[tuple[float, float]]) -> Any:
    """Return the polygon of a ring, which may go round holes too."""
    found = shapely.polygons(ring)
    return found if found.is_valid else shapely.make_valid(found)


def _overlap(bottom: float, top: float, other_bottom: float, other_top: float) -> bool:
    return bottom < other_top and other_bottom < top


def _polygons(part: Part, poses: Floats) -> Geometries:
    """Return a part's polygon at each pose; None where the pose is NaN."""
    corners = np.array(_corners(part))
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    x = poses[:, 0][:, None] + c * corners[:, 0] - s * corners[:, 1]
    y = poses[:, 1][:, None] + s * corners[:, 0] + c * corners[:, 1]
    present = np.isfinite(poses).all(axis=1)
    polygons: Geometries = np.full(len(poses), None, dtype=object)
    polygons[present] = shapely.polygons(np.stack([x, y], axis=2)[present])
    return polygons


def _corners(part: Part) -> Sequence[tuple[float, float]]:
    along, across = part.length / 2.0, part.width / 2.0
    return [(part.x + a * along, part.y + b * across) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
