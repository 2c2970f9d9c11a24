"""A map as the grid of ROS (`nav_msgs/OccupancyGrid`). Pure.

A cell is occupied if its centre is in a wall or an obstacle, or if an edge of one passes through it, so nothing thin is
lost. All other cells are free. Solids whose lower edge is above a seated person are left out.

Source:
    REP 105 for the frame; the cell (0, 0) is at the origin, rows go along y.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from intellwheels_agents.ros_gateway.plane_pose import PlanePose
from intellwheels_agents.ros_gateway.robot_frames import MAP
from intellwheels_agents.ros_gateway.ros_messages import header, pose_message, time_message
from intellwheels_agents.ros_gateway.ros_types import made_of
from intellwheels_maps.check import ring_of, wall_pieces
from intellwheels_schemas.messages import Map

RESOLUTION: Final = 0.05
"""Size of a cell, m."""
MARGIN: Final = 0.5
"""Free cells around the map, m."""
OVERHEAD: Final = 1.5
"""Solids from this height on are above a person in a wheelchair, m."""
MOST_CELLS: Final = 1_000_000
"""Cells of a grid that a router with this project's limit of 1 MiB for a message lets pass."""
MOST_WANTED: Final = 50_000_000
"""Cells of a grid whose resolution somebody asked for."""
OCCUPIED: Final = 100
_BLOCK: Final = 1_000_000
"""Crossings of rows and edges that are computed at once."""

Point = tuple[float, float]


def floor_grid(document: Map, resolution: float, seconds: float) -> Any:
    """Return the grid of a map.

    Args:
        document: The map.
        resolution: Size of a cell, m.
        seconds: Simulated time of the message.
    """
    west, south, columns, rows = _extent(document, resolution)
    cells = np.zeros((rows, columns), dtype=np.int8)
    changes = np.zeros((rows, columns + 1), dtype=np.int32)
    for ring in solids(document):
        in_cells = [((x - west) / resolution, (y - south) / resolution) for x, y in ring]
        _mark_edges(cells, in_cells)
        _count_inside(changes, in_cells)
    cells[np.cumsum(changes, axis=1)[:, :-1] > 0] = OCCUPIED
    info = made_of("nav_msgs/msg/MapMetaData")(
        map_load_time=time_message(0.0),
        resolution=resolution,
        width=columns,
        height=rows,
        origin=pose_message(PlanePose(west, south, 0.0)),
    )
    return made_of("nav_msgs/msg/OccupancyGrid")(header=header(MAP, seconds), info=info, data=cells.reshape(-1))


def fitting_resolution(document: Map, wanted: float = RESOLUTION) -> float:
    """Return the smallest size of a cell, m, of `wanted` and its doubles, with which a map has at most `MOST_CELLS`."""
    resolution = wanted
    while True:
        if cells_of(document, resolution) <= MOST_CELLS:
            return resolution
        resolution *= 2.0


def cells_of(document: Map, resolution: float) -> int:
    """Return the number of cells of the grid of a map."""
    _, _, columns, rows = _extent(document, resolution)
    return columns * rows


def solids(document: Map) -> Iterator[Sequence[Point]]:
    """Yield the outline of each wall and obstacle that a chair can meet, m."""
    for wall in document.wall:
        if wall.bottom < OVERHEAD:
            yield from wall_pieces(wall)
    for obstacle in document.obstacle:
        if obstacle.bottom < OVERHEAD:
            yield ring_of(obstacle.corner)


def _extent(document: Map, resolution: float) -> tuple[float, float, int, int]:
    """Return the corner of the first cell, m, and the numbers of columns and rows."""
    points = [point for ring in solids(document) for point in ring]
    if document.grid is not None:
        points += [(place.x, place.y) for place in document.grid.position]
    xs, ys = [x for x, _ in points] or [0.0], [y for _, y in points] or [0.0]
    west, south = (math.floor((min(values) - MARGIN) / resolution) * resolution for values in (xs, ys))
    columns = math.ceil((max(xs) + MARGIN - west) / resolution)
    rows = math.ceil((max(ys) + MARGIN - south) / resolution)
    return west, south, columns, rows


def _mark_edges(cells: npt.NDArray[np.int8], ring: Sequence[Point]) -> None:
    """Mark the cells that the edges of a polygon pass; its corners are in cells."""
    for (ax, ay), (bx, by) in zip(ring, (*ring[1:], ring[0]), strict=True):
        # Four points in each cell that the edge passes: it can only clip corners of less than a quarter of a cell.
        count = int(4.0 * math.hypot(bx - ax, by - ay)) + 1
        share = np.linspace(0.0, 1.0, count + 1)
        columns = (ax + share * (bx - ax)).astype(np.int64).clip(0, cells.shape[1] - 1)
        rows = (ay + share * (by - ay)).astype(np.int64).clip(0, cells.shape[0] - 1)
        cells[rows, columns] = OCCUPIED


def _count_inside(changes: npt.NDArray[np.int32], ring: Sequence[Point]) -> None:
    """Add a polygon, whose corners are in cells, to the changes along each row of the number of solids.

    From the left, a row enters a polygon at each odd crossing with an edge, and leaves it at each even one.
    """
    (ax, ay), (bx, by) = np.array(ring).T, np.array((*ring[1:], ring[0])).T
    first, last = max(0, int(ay.min())), min(changes.shape[0], int(ay.max()) + 1)
    step = max(1, _BLOCK // len(ring))
    for begin in range(first, last, step):
        rows = np.arange(begin, min(begin + step, last))
        centres = rows[:, None] + 0.5
        crosses = (ay > centres) != (by > centres)
        slope = (bx - ax) / np.where(ay == by, 1.0, by - ay)
        found = np.sort(np.where(crosses, ax + (centres - ay) * slope, np.inf), axis=1)
        for pair in range(0, int(crosses.sum(axis=1).max(initial=0)), 2):
            inside = np.isfinite(found[:, pair])
            for crossing, change in ((found[inside, pair], 1), (found[inside, pair + 1], -1)):
                columns = np.ceil(crossing - 0.5).astype(np.int64).clip(0, changes.shape[1] - 1)
                np.add.at(changes, (rows[inside], columns), change)
