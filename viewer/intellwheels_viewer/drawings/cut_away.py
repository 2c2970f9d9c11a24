"""Which parts of walls hide the body that a camera follows, and a map in which they are cut away. Pure."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from itertools import groupby, pairwise
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from intellwheels_schemas.messages import Corner, Map, Wall

Rows = npt.NDArray[np.float64]

PIECE: Final = 1.0
"""Greatest length of a part of a wall, in metres."""
STUB: Final = 0.2
"""Height at which a wall is cut away, in metres: where it is can still be seen."""
SEEN: Final = ((0.0, 0.0, 0.15), (0.45, 0.0, 0.5), (-0.45, 0.0, 0.5), (0.0, 0.45, 0.5), (0.0, -0.45, 0.5))
"""Points of a body that should be seen: offsets from its centre in metres, and heights."""


def pieces_of(floor: Map) -> Rows:
    """Return the parts of all walls that are lines, shape (n, 6): ends x, y, x, y, bottom and top, in metres."""
    rows = [
        (a[0], a[1], b[0], b[1], wall.bottom, wall.height)
        for wall in floor.wall
        for corners in _cut(wall)
        for a, b in pairwise(corners)
    ]
    return np.array(rows, np.float64).reshape(-1, 6)


def hidden(pieces: Rows, eye: tuple[float, float, float], at: tuple[float, float], height: float) -> frozenset[int]:
    """Return the indices of the parts that a camera does not see past.

    Args:
        pieces: The parts of walls, see `pieces_of`.
        eye: The camera.
        at: The centre of the body.
        height: Where walls are cut anyway.
    """
    ends = np.array([(at[0] + x, at[1] + y, z) for x, y, z in SEEN])
    start, along = np.array(eye), ends - np.array(eye)
    ax, ay, bx, by, bottom, top = pieces.T[:, :, None]
    sx, sy = bx - ax, by - ay
    dx, dy, dz = along.T[:, None, :]
    # Where the line of sight and the part of the wall cross in the plan: shares of both (two lines, Cramer's rule).
    turn = dx * sy - dy * sx
    with np.errstate(divide="ignore", invalid="ignore"):
        sight = ((ax - start[0]) * sy - (ay - start[1]) * sx) / turn
        share = ((ax - start[0]) * dy - (ay - start[1]) * dx) / turn
        level = start[2] + sight * dz
        crosses = (sight > 0.0) & (sight < 1.0) & (share >= -0.05) & (share <= 1.05)
        blocked = crosses & (level > bottom) & (level < np.minimum(top, height))
    return frozenset(int(index) for index in np.flatnonzero(blocked.any(axis=1)))


def cut_away(floor: Map, parts: Collection[int]) -> Map:
    """Return a map in which these parts of walls, see `pieces_of`, are cut at `STUB`."""
    if not parts:
        return floor
    walls: list[Wall] = []
    index = 0
    for wall in floor.wall:
        count = sum(len(corners) - 1 for corners in _cut(wall))
        if not any(index <= part < index + count for part in parts):
            walls.append(wall)
            index += count
            continue
        for corners in _cut(wall):
            steps = [(index + k in parts, pair) for k, pair in enumerate(pairwise(corners))]
            index += len(steps)
            for low, run in groupby(steps, key=lambda step: step[0]):
                pairs = [pair for _, pair in run]
                ends = tuple(Corner(x=x, y=y) for x, y in (pairs[0][0], pairs[-1][1]))
                height = min(wall.height, STUB) if low else wall.height
                walls.append(msgspec.structs.replace(wall, corner=ends, height=height))
    return msgspec.structs.replace(floor, wall=tuple(walls))


def _cut(wall: Wall) -> Iterator[list[tuple[float, float]]]:
    """Yield the corners of the parts of each segment of a wall. A polygon is not cut: it may be of any shape."""
    if wall.thickness is None:
        return
    for a, b in pairwise(wall.corner):
        count = max(1, math.ceil(math.hypot(b.x - a.x, b.y - a.y) / PIECE - 1e-9))
        yield [(a.x + (b.x - a.x) * k / count, a.y + (b.y - a.y) * k / count) for k in range(count + 1)]
