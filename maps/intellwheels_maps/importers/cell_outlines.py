"""The outlines of the walls in an image of cells. Pure. A cell is 1 x 1, x to the right and y down."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, Final

TOLERANCE: Final = 0.499
"""Farthest that an outline moves when it is simplified, in cells: less than from a cell's edge to its middle."""


def count_corners(walls: Any) -> int:
    """Return how many corners the outlines of the walls have before they are simplified, from bool[rows, columns]."""
    import numpy as np  # noqa: PLC0415 - of an extra

    padded = np.pad(walls, 1).astype(np.int8)
    around = padded[:-1, :-1] + padded[:-1, 1:] + padded[1:, :-1] + padded[1:, 1:]
    diagonal = (around == 2) & (padded[:-1, :-1] == padded[1:, 1:])
    return int(np.count_nonzero((around == 1) | (around == 3)) + 2 * np.count_nonzero(diagonal))


def cell_area(walls: Any) -> Any:
    """Return the union of the cells that are walls, whose area is exactly their number. `walls` is bool[rows, columns].

    Each run of walls in a row is a box. Equal runs of consecutive rows are one box.
    """
    import numpy as np  # noqa: PLC0415 - of an extra
    import shapely  # noqa: PLC0415

    edges = np.diff(np.pad(walls, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, start = np.nonzero(edges == 1)
    end = np.nonzero(edges == -1)[1]
    order = np.lexsort((row, end, start))
    row, start, end = row[order], start[order], end[order]
    new = np.ones(len(row), dtype=bool)
    new[1:] = (start[1:] != start[:-1]) | (end[1:] != end[:-1]) | (row[1:] != row[:-1] + 1)
    first = np.nonzero(new)[0]
    last = np.append(first[1:], len(row))[: len(first)] - 1
    return shapely.union_all(shapely.box(start[first], row[first], end[first], row[last] + 1))


def simplified(area: Any) -> Any:
    """Return an area of cells with simpler outlines, none of which moves by more than `TOLERANCE`.

    The middle of every cell stays on its side. Corners at which outlines touch stay where they are.
    """
    import shapely  # noqa: PLC0415 - of an extra

    polygons = shapely.get_parts(area)
    rings = [[polygon.exterior, *polygon.interiors] for polygon in polygons]
    corners = [shapely.get_coordinates(ring)[:-1].tolist() for part in rings for ring in part]
    seen: set[tuple[float, ...]] = set()
    shared: set[tuple[float, ...]] = set()
    for ring in corners:
        for corner in map(tuple, ring):
            (shared if corner in seen else seen).add(corner)
    # The ends of lines stay, so each ring is cut into lines. Within lines, shapely keeps to the tolerance.
    lines: list[Any] = []
    counts = []
    for ring in corners:
        ends = {0, len(ring) // 2} | {at for at, corner in enumerate(ring) if tuple(corner) in shared}
        cuts = [*sorted(ends), len(ring)]
        closed = [*ring, ring[0]]
        lines += [closed[one : other + 1] for one, other in pairwise(cuts)]
        counts.append(len(cuts) - 1)
    joint = shapely.simplify(shapely.MultiLineString(lines), TOLERANCE, preserve_topology=True)
    parts = iter([shapely.get_coordinates(line)[:-1].tolist() for line in shapely.get_parts(joint)])
    loops = iter([[corner for _ in range(count) for corner in next(parts)] for count in counts])
    return shapely.MultiPolygon([(next(loops), [next(loops) for _ in part[1:]]) for part in rings])
