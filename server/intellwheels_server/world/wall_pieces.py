"""The solids and lines of a map, cut into convex pieces and sorted into a grid, as the kernels need them.

Pure, and exact where possible: corners keep their coordinates, a solid that is not convex is cut along diagonals
between its own corners, and orientation is decided in rational arithmetic. The same input gives the same pieces, in the
same order, on every machine.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from shapely.geometry import Polygon
from shapely.validation import explain_validity

from intellwheels_maps.crossing import Point, orientation
from intellwheels_maps.keyholes import find_fault
from intellwheels_server.world.convex_pieces import convex_pieces
from intellwheels_server.world.kernels.arrays import Floats, Walls
from intellwheels_server.world.kernels.grid import fill_cells

__all__ = ["Line", "Solid", "Walls", "walls_from"]

# Shortest edge, m: contact cannot tell corners apart that are closer.
_SHORTEST = 1e-9
# Side of a grid cell, m. Cells are about as large as the surroundings of a chair, so a search visits about four.
_CELL = 1.0
# Largest number of cells. A map that would need more gets larger cells.
_MOST_CELLS = 1 << 16
# Largest number of entries of pieces in cells. A slanting wall has an entry in every cell of its bounding box.
_MOST_ITEMS = 1 << 20


@dataclass(frozen=True)
class Solid:
    """A filled polygon.

    Attributes:
        corners: At least three, in either direction, not crossing itself; m. The last may repeat the first.
        bottom: Lower end, m.
        top: Upper end, m, above `bottom`.
    """

    corners: Sequence[Point]
    bottom: float
    top: float


@dataclass(frozen=True)
class Line:
    """A wall of constant thickness along a line, which is closed if its last corner is its first.

    Attributes:
        corners: At least two, m. Turns up to a right angle are mitred; sharper ones are cut flat.
        thickness: m, > 0, half of it to each side.
        bottom: Lower end, m.
        top: Upper end, m, above `bottom`.
    """

    corners: Sequence[Point]
    thickness: float
    bottom: float
    top: float


@dataclass(frozen=True)
class _Piece:
    """A convex polygon, anticlockwise. `outer` says of the edge from each corner whether it is an edge of the wall."""

    corners: tuple[Point, ...]
    outer: tuple[bool, ...]


def walls_from(walls: Sequence[Solid | Line]) -> Walls:
    """Return the walls as convex pieces.

    Args:
        walls: The walls; the order gives each its index.

    Raises:
        ValueError: A wall has too few corners, crosses itself, has no area or an impossible size; the text names it
            by its index.
    """
    pieces: list[list[float]] = []
    links: list[tuple[int, int, int]] = []
    edges: list[tuple[float, ...]] = []
    for index, wall in enumerate(walls):
        where = f"wall {index}"
        _check_heights(where, wall)
        found = _solid_pieces(where, wall) if isinstance(wall, Solid) else _line_pieces(where, wall)
        for piece in found:
            first = len(edges)
            sides = _edges(where, piece.corners)
            edges.extend((*side, float(outer)) for side, outer in zip(sides, piece.outer, strict=True))
            links.append((first, len(edges), index))
            xs = [x for x, _ in piece.corners]
            ys = [y for _, y in piece.corners]
            pieces.append([min(xs), min(ys), max(xs), max(ys), wall.bottom, wall.top, _thickness(piece, sides)])
    piece_block = np.array(pieces, dtype=np.float64).reshape(-1, 7)
    frame, columns, rows = _frame(piece_block)
    return Walls(
        pieces=piece_block,
        links=np.array(links, dtype=np.int64).reshape(-1, 3),
        edges=np.array(edges, dtype=np.float64).reshape(-1, 6),
        cells=fill_cells(piece_block, frame[0], frame[1], frame[2], columns, rows),
        frame=np.array(frame, dtype=np.float64),
    )


def _check_heights(where: str, wall: Solid | Line) -> None:
    if not (math.isfinite(wall.bottom) and math.isfinite(wall.top) and wall.bottom < wall.top):
        raise ValueError(f"{where}: expected a top above its bottom, got bottom {wall.bottom:g} and top {wall.top:g}")
    for corner in wall.corners:
        if not all(map(math.isfinite, corner)):
            raise ValueError(f"{where}: expected finite corners, got {corner}")


def _frame(pieces: Floats) -> tuple[tuple[float, float, float], int, int]:
    """Return the origin and cell size of the grid, and its numbers of columns and rows."""
    if len(pieces) == 0:
        return (0.0, 0.0, _CELL), 1, 1
    x0, y0 = float(pieces[:, 0].min()), float(pieces[:, 1].min())
    width, height = float(pieces[:, 2].max()) - x0, float(pieces[:, 3].max()) - y0
    size = _CELL
    while (int(width / size) + 1) * (int(height / size) + 1) > _MOST_CELLS or _items(pieces, size) > _MOST_ITEMS:
        size *= 2.0
    return (x0, y0, size), int(width / size) + 1, int(height / size) + 1


def _items(pieces: Floats, size: float) -> float:
    """Return roughly how many entries the pieces have in cells of a size, beyond one for each piece."""
    spans = ((pieces[:, 2] - pieces[:, 0]) / size + 1.0) * ((pieces[:, 3] - pieces[:, 1]) / size + 1.0)
    return float(spans.sum()) - len(pieces)


# ---------------------------------------------------------------- convex polygons


def _edges(where: str, corners: Sequence[Point]) -> list[tuple[float, float, float, float, float]]:
    rows = []
    for (x, y), (x2, y2) in zip(corners, [*corners[1:], corners[0]], strict=True):
        dx, dy = x2 - x, y2 - y
        length = math.sqrt(dx * dx + dy * dy)
        if length < _SHORTEST:
            raise ValueError(
                f"{where}: expected corners at least {_SHORTEST:g} m apart, got ({x}, {y}) and ({x2}, {y2})"
            )
        nx, ny = dy / length, -dx / length
        rows.append((x, y, nx, ny, nx * x + ny * y))
    return rows


def _thickness(piece: _Piece, edges: Sequence[tuple[float, float, float, float, float]]) -> float:
    """Return the least width of a piece between outer edges that face away from each other, or infinity if none do.

    Only such edges make a wall thin. Edges along which a solid was cut lead to the next piece, and a piece with outer
    edges on one side only cannot be passed through.
    """
    outer = np.array([edge for edge, is_outer in zip(edges, piece.outer, strict=True) if is_outer]).reshape(-1, 5)
    corners = np.array(piece.corners)
    least = math.inf
    for _, _, nx, ny, offset in outer:
        if (nx * outer[:, 2] + ny * outer[:, 3] < 0.0).any():
            least = min(least, float((offset - (nx * corners[:, 0] + ny * corners[:, 1])).max()))
    return least


# ---------------------------------------------------------------- solids


def _solid_pieces(where: str, wall: Solid) -> list[_Piece]:
    corners = [(float(x), float(y)) for x, y in wall.corners]
    if len(corners) > 1 and corners[0] == corners[-1]:
        corners.pop()
    if len(corners) < 3:
        raise ValueError(f"{where}: a solid needs at least 3 corners, got {len(corners)}")
    if all(orientation(corners[0], b, c) == 0 for b, c in pairwise(corners)):
        raise ValueError(f"{where}: expected an area, got corners in one line")
    polygon = Polygon(corners)
    has_holes = len(set(corners)) < len(corners) and find_fault(corners) is None
    if not has_holes and not polygon.is_valid:
        raise ValueError(f"{where}: expected a polygon that does not cross itself, got {explain_validity(polygon)}")
    if (math.fsum(_doubled_areas(corners)) < 0.0) if has_holes else not polygon.exterior.is_ccw:
        corners.reverse()
    ring = _without_straight(corners)
    pieces = convex_pieces(ring)
    if pieces is None:
        raise ValueError(f"{where}: expected a polygon that does not touch itself")
    size = len(ring)
    # An edge that leads to a hole and back is inside the wall.
    edges = {(ring[i - 1], ring[i]) for i in range(size)} if has_holes else set()
    return [
        _Piece(
            tuple(ring[i] for i in piece),
            tuple(
                (a + 1) % size == b and (ring[b], ring[a]) not in edges
                for a, b in zip(piece, [*piece[1:], piece[0]], strict=True)
            ),
        )
        for piece in pieces
    ]


def _doubled_areas(corners: Sequence[Point]) -> Iterator[float]:
    return (a[0] * b[1] - b[0] * a[1] for a, b in zip(corners, [*corners[1:], corners[0]], strict=True))


def _without_straight(corners: list[Point]) -> list[Point]:
    """Return the ring without corners at which it goes straight on, except those to which it comes back."""
    size = len(corners)
    counts = Counter(corners)
    return [
        corners[i]
        for i in range(size)
        if counts[corners[i]] > 1 or orientation(corners[i - 1], corners[i], corners[(i + 1) % size]) != 0
    ]


# ---------------------------------------------------------------- lines


def _line_pieces(where: str, wall: Line) -> list[_Piece]:
    corners = [(float(x), float(y)) for x, y in wall.corners]
    if len(corners) < 2:
        raise ValueError(f"{where}: a line needs at least 2 corners, got {len(corners)}")
    if not (math.isfinite(wall.thickness) and wall.thickness >= _SHORTEST):
        raise ValueError(f"{where}: expected a thickness of at least {_SHORTEST:g} m, got {wall.thickness:g}")
    half = wall.thickness / 2.0
    steps = list(pairwise(corners))
    for k, (a, b) in enumerate(steps):
        if a == b:
            raise ValueError(f"{where}: expected corners that differ, got {a} twice, at {k} and {k + 1}")
        if max(abs(b[0] - a[0]), abs(b[1] - a[1])) < _SHORTEST:
            raise ValueError(f"{where}: expected corners at least {_SHORTEST:g} m apart, got {a} and {b}")
    boxes = [_box_along(a, b, half) for a, b in steps]
    joints = list(pairwise(steps))
    if len(steps) > 2 and corners[0] == corners[-1]:
        joints.append((steps[-1], steps[0]))
    return boxes + [joint for before, after in joints if (joint := _joint(before, after, half)) is not None]


def _direction(a: Point, b: Point) -> Point:
    dx, dy = b[0] - a[0], b[1] - a[1]
    length = math.sqrt(dx * dx + dy * dy)
    return dx / length, dy / length


def _box_along(a: Point, b: Point, half: float) -> _Piece:
    ux, uy = _direction(a, b)
    sx, sy = -uy * half, ux * half
    return _Piece(
        ((a[0] - sx, a[1] - sy), (b[0] - sx, b[1] - sy), (b[0] + sx, b[1] + sy), (a[0] + sx, a[1] + sy)), (True,) * 4
    )


def _joint(before: tuple[Point, Point], after: tuple[Point, Point], half: float) -> _Piece | None:
    """Return the piece that fills the outer side of a turn, or None if the line goes straight on or back."""
    ux, uy = _direction(*before)
    vx, vy = _direction(*after)
    cross, dot = ux * vy - uy * vx, ux * vx + uy * vy
    # A smaller turn leaves a gap below the tolerance of contact; a line that turns back on itself leaves none.
    if half * abs(cross) < _SHORTEST:
        return None
    side = 1.0 if cross > 0.0 else -1.0
    x, y = after[0]
    first = (x + side * uy * half, y - side * ux * half)
    second = (x + side * vy * half, y - side * vx * half)
    if dot < -1e-12:
        corners = [(x, y), first, second]
    else:
        reach = half * abs(cross) / (1.0 + dot)
        corners = [(x, y), first, (first[0] + ux * reach, first[1] + uy * reach), second]
    outer = (False, *(True,) * (len(corners) - 2), False)
    if side < 0.0:
        corners = [corners[0], *corners[:0:-1]]
    return _Piece(tuple(corners), outer)
