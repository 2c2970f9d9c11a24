"""How far the footprint of a body is from everything on the map, for each pose of a lattice.

The body is boxes, the map is outlines, and both have heights: a box meets the outlines whose heights it shares. For a
pose and an edge the clearance is the largest gap over the axes of the box and the normal of the edge (separating axes):
exact beside a face, up to 0.3 times too small at a corner, never too large. Inside a solid it is negative.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from intellwheels_agents.navigation.array_angles import Floats
from intellwheels_agents.navigation.lattice import COSINES, COUNT, SINES
from intellwheels_agents.portable_math import dist, hypot
from intellwheels_maps.check import points_of, ring_of, wall_pieces
from intellwheels_schemas.messages import Map, Part, Robot
from intellwheels_schemas.rules import parts_of

CUTOFF: Final = 0.3
"""Clearances above this are not told apart, m."""
INSIDE: Final = -1.0
"""The clearance of a pose whose centre is inside a solid, m."""
BORDER: Final = 5
"""Cells of border around the map that no body can enter: as many as the longest move has."""


class Solid(NamedTuple):
    """An outline of the map with its heights, m."""

    corners: tuple[tuple[float, float], ...]
    bottom: float
    top: float


class Box(NamedTuple):
    """A part of a body in plan with its heights, m."""

    front: float
    back: float
    left: float
    right: float
    bottom: float
    top: float


class Frame(NamedTuple):
    """A grid of cells: the centre of its cell (0, 0), the size of a cell (m), and the number of columns and rows."""

    x: float
    y: float
    cell: float
    columns: int
    rows: int


def solids_of(document: Map) -> list[Solid]:
    """Return the outlines of the walls and obstacles of a map."""
    found = [Solid(tuple(piece), wall.bottom, wall.height) for wall in document.wall for piece in wall_pieces(wall)]
    return found + [
        Solid(tuple(ring_of(obstacle.corner)), obstacle.bottom, obstacle.top) for obstacle in document.obstacle
    ]


def boxes_of(robot: Robot) -> list[Box]:
    """Return the parts of a body; its y axis points to the left."""
    return [_box(part) for part in parts_of(robot)]


def covering(boxes: list[Box]) -> list[Box]:
    """Return the boxes that no other one covers in plan."""
    return [box for box in boxes if not any(_covers(other, box) for other in boxes if other is not box)]


def reach_of(boxes: list[Box]) -> float:
    """Return the longest distance from a body's centre to a point at which its clearance is below the cutoff, m."""
    corners = ((max(box.front, -box.back), max(box.left, -box.right)) for box in boxes)
    return max(hypot(x, y) for x, y in corners) + 1.5 * CUTOFF


def _box(part: Part) -> Box:
    return Box(
        part.x + part.length / 2.0, part.x - part.length / 2.0, part.y + part.width / 2.0, part.y - part.width / 2.0,
        part.bottom, part.top,
    )  # fmt: skip


def frame_of(document: Map, cell: float) -> Frame:
    """Return the grid that covers a map."""
    points = [point for solid in solids_of(document) for point in solid.corners]
    points += [(place.x, place.y) for place in (document.grid.position if document.grid else ())]
    points += points_of(()) or [(0.0, 0.0)]
    low_x, low_y = min(x for x, _ in points), min(y for _, y in points)
    high_x, high_y = max(x for x, _ in points), max(y for _, y in points)
    # Cell centres on multiples of the cell size, so that maps drawn in decimetres have cells on their middle lines.
    first_x, first_y = (low_x / cell) // 1.0 - BORDER, (low_y / cell) // 1.0 - BORDER
    columns = int((high_x / cell) // 1.0 - first_x) + 1 + BORDER
    rows = int((high_y / cell) // 1.0 - first_y) + 1 + BORDER
    return Frame(first_x * cell, first_y * cell, cell, columns, rows)


def clearances(frame: Frame, solids: list[Solid], boxes: list[Box]) -> npt.NDArray[np.float32]:
    """Return the clearances of a body, m, by heading, row and column."""
    field = np.full((COUNT, frame.rows, frame.columns), CUTOFF, dtype=np.float32)
    for solid in solids:
        mark(field, frame, solid, boxes)
    field[:, :BORDER], field[:, -BORDER:], field[:, :, :BORDER], field[:, :, -BORDER:] = (INSIDE,) * 4
    return field


def mark(field: npt.NDArray[np.float32], frame: Frame, solid: Solid, boxes: list[Box]) -> None:
    """Lower the clearances near one solid."""
    met = [box for box in boxes if box.bottom < solid.top and solid.bottom < box.top]
    for box in covering(met):
        ends = [*solid.corners[1:], solid.corners[0]] if len(solid.corners) > 2 else solid.corners[1:] or solid.corners
        for a, b in zip(solid.corners, ends, strict=False):
            _mark_edge(field, frame, a, b, box)
    if met and len(solid.corners) > 2:
        _mark_inside(field, frame, solid)


def _covers(one: Box, other: Box) -> bool:
    """Return whether a box covers another in plan; of two equal ones, the upper covers the lower."""
    inside = one.front >= other.front and one.back <= other.back and one.left >= other.left and one.right <= other.right
    return inside and (one[:4] != other[:4] or one.bottom > other.bottom)


def _mark_edge(
    field: npt.NDArray[np.float32], frame: Frame, a: tuple[float, float], b: tuple[float, float], box: Box
) -> None:
    radius = reach_of([box])
    columns = _span(frame.x, frame.cell, frame.columns, min(a[0], b[0]) - radius, max(a[0], b[0]) + radius)
    rows = _span(frame.y, frame.cell, frame.rows, min(a[1], b[1]) - radius, max(a[1], b[1]) + radius)
    if columns.start >= columns.stop or rows.start >= rows.stop:
        return
    x = (frame.x + frame.cell * np.arange(columns.start, columns.stop))[None, None, :]
    y = (frame.y + frame.cell * np.arange(rows.start, rows.stop))[None, :, None]
    c, s = COSINES[:, None, None], SINES[:, None, None]
    along_a, along_b = c * (a[0] - x) + s * (a[1] - y), c * (b[0] - x) + s * (b[1] - y)
    across_a, across_b = c * (a[1] - y) - s * (a[0] - x), c * (b[1] - y) - s * (b[0] - x)
    gap = np.maximum(np.minimum(along_a, along_b) - box.front, box.back - np.maximum(along_a, along_b))
    np.maximum(gap, np.minimum(across_a, across_b) - box.left, out=gap)
    np.maximum(gap, box.right - np.maximum(across_a, across_b), out=gap)
    length = dist(a, b)
    if length > 0.0:
        nx, ny = (b[1] - a[1]) / length, (a[0] - b[0]) / length
        # The normal in the body's frame, how far the box extends along it, and how far the edge is.
        n_along, n_across = c * nx + s * ny, c * ny - s * nx
        most = np.maximum(n_along * box.front, n_along * box.back) + np.maximum(
            n_across * box.left, n_across * box.right
        )
        least = np.minimum(n_along * box.front, n_along * box.back) + np.minimum(
            n_across * box.left, n_across * box.right
        )
        off = nx * (a[0] - x) + ny * (a[1] - y)
        np.maximum(gap, np.maximum(off - most, least - off), out=gap)
    part = field[:, rows, columns]
    np.minimum(part, gap.astype(np.float32), out=part)


def _mark_inside(field: npt.NDArray[np.float32], frame: Frame, solid: Solid) -> None:
    xs, ys = [x for x, _ in solid.corners], [y for _, y in solid.corners]
    columns = _span(frame.x, frame.cell, frame.columns, min(xs), max(xs))
    rows = _span(frame.y, frame.cell, frame.rows, min(ys), max(ys))
    x = (frame.x + frame.cell * np.arange(columns.start, columns.stop))[None, :]
    y = (frame.y + frame.cell * np.arange(rows.start, rows.stop))[:, None]
    inside = np.zeros((y.shape[0], x.shape[1]), dtype=bool)
    for (ax, ay), (bx, by) in zip(solid.corners, (*solid.corners[1:], solid.corners[0]), strict=True):
        if ay != by:
            inside ^= ((ay > y) != (by > y)) & (x < ax + (y - ay) / (by - ay) * (bx - ax))
    part = field[:, rows, columns]
    part[:, inside] = INSIDE


def _span(first: float, cell: float, count: int, low: float, high: float) -> slice:
    """Return the cells from `low` to `high`, m."""
    start = max(0, int(-((first - low) / cell // 1.0)) if low > first else 0)
    stop = min(count, int((high - first) / cell // 1.0) + 1) if high >= first else 0
    return slice(start, max(start, stop))


def points_along(solid: Solid, spacing: float) -> Floats:
    """Return points on an outline, at most `spacing` m apart, as rows x, y."""
    found: list[Floats] = []
    for (ax, ay), (bx, by) in zip(solid.corners, (*solid.corners[1:], solid.corners[0]), strict=True):
        count = max(1, int(dist((ax, ay), (bx, by)) / spacing) + 1)
        share = np.arange(count)[:, None] / count
        found.append(np.array([[ax, ay]]) + share * np.array([[bx - ax, by - ay]]))
    return np.concatenate(found)


def hidden_points(solids: list[Solid], boxes: list[Box], height: float | None) -> Floats:
    """Return points on what a body can meet and a sensor at a height (m) does not see; on everything without one."""
    found = [
        points_along(solid, 0.05)
        for solid in solids
        if any(box.bottom < solid.top and solid.bottom < box.top for box in boxes)
        and (height is None or not solid.bottom <= height < solid.top)
    ]
    return np.concatenate(found) if found else np.zeros((0, 2))
