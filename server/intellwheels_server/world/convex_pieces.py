"""Cuts a polygon that is not convex into convex pieces, along diagonals between its own corners.

Ears are clipped, and then pieces that are convex together are merged. The same ring gives the same pieces, in the same
order, on every machine: all turns are decided exactly.
"""

from __future__ import annotations

import heapq

import numpy as np

from intellwheels_maps.crossing import NO_UNDERFLOW, SURE, Point, orientation
from intellwheels_server.world.kernels.arrays import Floats


def convex_pieces(ring: list[Point]) -> list[list[int]] | None:
    """Return the pieces of a ring, each by the indices of its corners, anticlockwise.

    Args:
        ring: The corners, anticlockwise, none of them in line with its neighbours.

    Returns:
        The pieces, or None if the ring touches itself.
    """
    clipping = _EarClipping(ring)
    triangles: list[list[int]] = []
    while not clipping.is_convex:
        triangle = clipping.clip()
        if triangle is None:
            return None
        triangles.append(triangle)
    return _merged(ring, [*triangles, clipping.left()])


class _EarClipping:
    """Clips the ears of a ring, always the first one.

    A corner is an ear if it turns left and no other corner is in the triangle that clipping it would cut off. What a
    corner is changes only with its neighbours, or when the corner that is in its triangle is clipped.
    """

    def __init__(self, ring: list[Point]) -> None:
        size = len(ring)
        self._ring = ring
        self._xy = np.array(ring, dtype=np.float64)
        self._is_left = np.ones(size, dtype=bool)
        self._count = size
        self._before = [i - 1 for i in range(size)]
        self._before[0] = size - 1
        self._after = [(i + 1) % size for i in range(size)]
        self._turn = [orientation(ring[self._before[i]], ring[i], ring[self._after[i]]) for i in range(size)]
        self._not_left_turns = sum(turn <= 0 for turn in self._turn)
        # Corners that are to be looked at, the first one first, and those whose triangle holds a corner, by that one.
        self._due = list(range(size))
        self._is_due = [True] * size
        self._blocked: dict[int, list[int]] = {}

    @property
    def is_convex(self) -> bool:
        """Whether what is left is convex, or a triangle."""
        return self._count <= 3 or self._not_left_turns == 0

    def left(self) -> list[int]:
        """Return the corners that are left, in order."""
        return [int(i) for i in np.flatnonzero(self._is_left)]

    def clip(self) -> list[int] | None:
        """Clip the first ear and return its corners, or None if there is no ear."""
        while self._due:
            tip = heapq.heappop(self._due)
            self._is_due[tip] = False
            if not self._is_left[tip] or self._turn[tip] <= 0:
                continue
            inside = self._corner_inside(tip)
            if inside is None:
                return self._cut(tip)
            self._blocked.setdefault(inside, []).append(tip)
        return None

    def _cut(self, tip: int) -> list[int]:
        before, after = self._before[tip], self._after[tip]
        self._is_left[tip] = False
        self._count -= 1
        self._after[before], self._before[after] = after, before
        for corner in (before, after):
            turn = orientation(self._ring[self._before[corner]], self._ring[corner], self._ring[self._after[corner]])
            self._not_left_turns += (turn <= 0) - (self._turn[corner] <= 0)
            self._turn[corner] = turn
        for corner in (before, after, *self._blocked.pop(tip, ())):
            if not self._is_due[corner]:
                self._is_due[corner] = True
                heapq.heappush(self._due, corner)
        return [before, tip, after]

    def _corner_inside(self, tip: int) -> int | None:
        """Return a corner inside the triangle at `tip` or on its edge, or None."""
        corners = (self._before[tip], tip, self._after[tip])
        a, b, c = (self._ring[corner] for corner in corners)
        x, y = self._xy[:, 0], self._xy[:, 1]
        near = (
            self._is_left
            & (x >= min(a[0], b[0], c[0])) & (x <= max(a[0], b[0], c[0]))
            & (y >= min(a[1], b[1], c[1])) & (y <= max(a[1], b[1], c[1]))
        )  # fmt: skip
        near[list(corners)] = False
        found = np.flatnonzero(near)
        if len(found) == 0:
            return None
        sides = [_sides_of(one, other, self._xy[found]) for one, other in ((a, b), (b, c), (c, a))]
        certain = np.minimum.reduce(sides)
        if (certain > 0).any():
            return int(found[np.argmax(certain > 0)])
        # The sign of a nought is uncertain: decided exactly, for the few that are not outside for certain.
        for corner in found[certain == 0]:
            p = self._ring[corner]
            if orientation(a, b, p) >= 0 and orientation(b, c, p) >= 0 and orientation(c, a, p) >= 0:
                return int(corner)
        return None


def _sides_of(a: Point, b: Point, points: Floats) -> Floats:
    """Return 1 for points left of a line, -1 for points right of it, 0 where rounding leaves it open.

    The bound is that of `orientation`.
    """
    one, other = (b[0] - a[0]) * (points[:, 1] - a[1]), (b[1] - a[1]) * (points[:, 0] - a[0])
    size = np.abs(one) + np.abs(other)
    return np.where((np.abs(one - other) > SURE * size) & (size > NO_UNDERFLOW), np.sign(one - other), 0.0)


def _merged(ring: list[Point], pieces: list[list[int]]) -> list[list[int]]:
    """Return the pieces after merging those that are convex together (Hertel and Mehlhorn, 1983).

    Each piece takes in its neighbours as long as one fits. Two that do not fit never do later: growing makes no corner
    less wide.
    """
    owner = {edge: k for k, piece in enumerate(pieces) for edge in _sides(piece)}
    whole: list[list[int] | None] = list(pieces)
    refused: set[tuple[int, int]] = set()
    for k in range(len(whole)):
        grown = True
        while grown:
            grown = False
            piece = whole[k]
            if piece is None:
                break
            for a, b in _sides(piece):
                other = None if (a, b) in refused else owner.get((b, a))
                neighbour = None if other is None else whole[other]
                if other is None or neighbour is None:
                    continue
                joined = _from(piece, b) + _from(neighbour, a)[1:-1]
                if _turns_left(ring, joined, len(piece) - 1):
                    whole[k], whole[other] = joined, None
                    owner.update(dict.fromkeys(_sides(joined), k))
                    del owner[a, b], owner[b, a]
                    grown = True
                    break
                refused |= {(a, b), (b, a)}
    return [piece for piece in whole if piece is not None]


def _sides(piece: list[int]) -> list[tuple[int, int]]:
    return list(zip(piece, [*piece[1:], piece[0]], strict=True))


def _from(piece: list[int], first: int) -> list[int]:
    """Return the piece rotated so that it starts with the corner `first`."""
    at = piece.index(first)
    return piece[at:] + piece[:at]


def _turns_left(ring: list[Point], joined: list[int], last: int) -> bool:
    """Return whether a piece turns left, or goes on, at both ends of the edge along which it was joined.

    Args:
        ring: The corners.
        joined: The piece, which begins at one end of that edge.
        last: Where the other end is.
    """
    size = len(joined)
    return all(orientation(ring[joined[i - 1]], ring[joined[i]], ring[joined[(i + 1) % size]]) >= 0 for i in (0, last))
