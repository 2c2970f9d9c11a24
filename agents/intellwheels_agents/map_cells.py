"""A map as cells: 1 where an edge or the inside of a solid is, else 0. Pure.

A cell is occupied if an edge of a wall or an obstacle passes through it, or if its centre is inside one, so nothing
thin is lost. Solids whose lower edge is above a seated person are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

from intellwheels_maps.check import ring_of, wall_pieces
from intellwheels_schemas.messages import Map

RESOLUTION: Final = 0.05
"""Size of a cell, m."""
MARGIN: Final = 0.5
"""Free cells around the map, m."""
OVERHEAD: Final = 1.5
"""Solids from this height on are above a person in a wheelchair, m."""
MOST_CELLS: Final = 1_000_000
"""Cells of a grid; a larger map gets larger cells."""
MOST_ROWS: Final = 200_000
"""Rows that all edges of a map cross together: a map from a stranger costs a bounded time."""

Point = tuple[float, float]


class MapCells(NamedTuple):
    """The cells of a map.

    Attributes:
        west, south: The corner of the first cell in the map frame, m.
        size: Size of a cell, m.
        columns, rows: Their numbers; rows go along y.
        cells: A byte for each cell, row by row, the southernmost row first: 1 is occupied.
    """

    west: float
    south: float
    size: float
    columns: int
    rows: int
    cells: bytes


class GridPlan(NamedTuple):
    """What a grid of a map would cost.

    Attributes:
        cells: Its cells.
        rows: The rows that all edges cross together.
    """

    cells: int
    rows: int


def plan_of(document: Map, size: float) -> GridPlan:
    """Return what the grid of a map costs.

    Args:
        document: The map.
        size: Size of a cell, m.
    """
    rings = _rings(document)
    _, _, columns, rows = _extent(document, rings, size)
    return GridPlan(columns * rows, _rows(rings, size))


def fitting_size(document: Map, wanted: float = RESOLUTION) -> float:
    """Return the smallest size of a cell, m, of `wanted` and its doubles, within `MOST_CELLS` and `MOST_ROWS`."""
    size, rings = wanted, _rings(document)
    # Each edge crosses a row at least, so larger cells help no more when most edges are short.
    most_rows = max(MOST_ROWS, 2 * len([point for ring in rings for point in ring]))
    while True:
        _, _, columns, rows = _extent(document, rings, size)
        if columns * rows <= MOST_CELLS and _rows(rings, size) <= most_rows:
            return size
        size *= 2.0


def map_cells(document: Map, size: float | None = None) -> MapCells:
    """Return the cells of a map.

    Args:
        document: The map.
        size: Size of a cell, m; None for the one that fits.
    """
    size = fitting_size(document) if size is None else size
    rings = _rings(document)
    west, south, columns, rows = _extent(document, rings, size)
    cells = [bytearray(columns) for _ in range(rows)]
    for ring in rings:
        in_cells = [((x - west) / size, (y - south) / size) for x, y in ring]
        for a, b in _edges(in_cells):
            _mark_edge(cells, a, b)
        _fill(cells, in_cells)
    return MapCells(west, south, size, columns, rows, b"".join(cells))


def solids(document: Map) -> Iterator[Sequence[Point]]:
    """Yield the outline of each wall and obstacle that a chair can meet, m."""
    for wall in document.wall:
        if wall.bottom < OVERHEAD:
            yield from wall_pieces(wall)
    for obstacle in document.obstacle:
        if obstacle.bottom < OVERHEAD:
            yield ring_of(obstacle.corner)


def _rings(document: Map) -> list[Sequence[Point]]:
    return [ring for ring in solids(document) if len(ring) >= 2]


def _rows(rings: Sequence[Sequence[Point]], size: float) -> int:
    return round(math.fsum(abs(a[1] - b[1]) / size + 1.0 for ring in rings for a, b in _edges(ring)))


def _edges(ring: Sequence[Point]) -> Iterator[tuple[Point, Point]]:
    return zip(ring, (*ring[1:], ring[0]), strict=True)


def _extent(document: Map, rings: Sequence[Sequence[Point]], size: float) -> tuple[float, float, int, int]:
    """Return the corner of the first cell, m, and the numbers of columns and rows."""
    points = [point for ring in rings for point in ring]
    if document.grid is not None:
        points += [(place.x, place.y) for place in document.grid.position]
    xs, ys = [x for x, _ in points] or [0.0], [y for _, y in points] or [0.0]
    west, south = (math.floor((min(values) - MARGIN) / size) * size for values in (xs, ys))
    columns, rows = (math.ceil((max(values) + MARGIN - least) / size) for values, least in ((xs, west), (ys, south)))
    return west, south, columns, rows


def _mark_edge(cells: list[bytearray], a: Point, b: Point) -> None:
    """Mark the cells that an edge passes; its ends are in cells."""
    (ax, ay), (bx, by) = (a, b) if a[1] <= b[1] else (b, a)
    slope = (bx - ax) / (by - ay) if by > ay else 0.0
    for row in range(int(ay), min(int(by), len(cells) - 1) + 1):
        low, high = ax + (max(ay, row) - ay) * slope, ax + (min(by, row + 1.0) - ay) * slope
        ends = (low, high) if by > ay else (ax, bx)
        first, last = int(min(ends)), min(int(max(ends)), len(cells[row]) - 1)
        cells[row][first : last + 1] = b"\1" * (last + 1 - first)


def _fill(cells: list[bytearray], ring: Sequence[Point]) -> None:
    """Mark the cells whose centres are inside a polygon: between odd and even crossings of its row."""
    crossings: dict[int, list[float]] = {}
    for a, b in _edges(ring):
        (ax, ay), (bx, by) = (a, b) if a[1] <= b[1] else (b, a)
        for row in range(math.ceil(ay - 0.5), min(math.ceil(by - 0.5), len(cells))):
            crossings.setdefault(row, []).append(ax + (row + 0.5 - ay) * (bx - ax) / (by - ay))
    for row, found in crossings.items():
        found.sort()
        for enter, leave in zip(found[::2], found[1::2], strict=False):
            first, last = math.ceil(enter - 0.5), math.ceil(leave - 0.5)
            if last > first:
                cells[row][first:last] = b"\1" * (last - first)
