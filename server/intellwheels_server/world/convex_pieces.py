"""Cuts a polygon that is not convex into convex pieces, along diagonals between its own corners.

Ears are clipped, and then pieces that are convex together are merged. The same ring gives the same pieces, in the same
order, on every machine: all turns are decided exactly.
"""

from __future__ import annotations

import heapq
from collections import deque
from typing import TypeAlias

import numpy as np

from intellwheels_maps.crossing import Point, orientation
from intellwheels_server.world.kernels.corner_search import corners_in_triangle


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
        self._is_left = np.ones(size, dtype=np.int64)
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
        self._is_left[tip] = 0
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
        one, other = self._before[tip], self._after[tip]
        inside, open_ones = corners_in_triangle(self._xy, self._is_left, one, tip, other)
        if inside >= 0:
            return int(inside)
        a, b, c = self._ring[one], self._ring[tip], self._ring[other]
        for corner in open_ones.tolist():
            p = self._ring[corner]
            if orientation(a, b, p) >= 0 and orientation(b, c, p) >= 0 and orientation(c, a, p) >= 0:
                return int(corner)
        return None


_Side: TypeAlias = tuple[int, int]
"""The corners at which a side begins and ends. No two pieces have the same one; neighbours have opposite ones."""


def _merged(ring: list[Point], pieces: list[list[int]]) -> list[list[int]]:
    """Return the pieces after merging those that are convex together (Hertel and Mehlhorn, 1983)."""
    merging = _Merging(ring, pieces)
    return [merging.grow(k) for k in range(len(pieces)) if not merging.is_taken(k)]


class _Merging:
    """Pieces that take in their neighbours, each as long as one fits.

    Two that do not fit never do later: growing makes no corner less wide. So each side is looked at once. The sides of
    a piece are linked, so that taking in a neighbour costs as much as the neighbour has sides.
    """

    def __init__(self, ring: list[Point], pieces: list[list[int]]) -> None:
        self._ring = ring
        self._pieces = pieces
        self._owner: dict[_Side, int] = {}
        # The corner before the side, and the one after it.
        self._before: dict[_Side, int] = {}
        self._after: dict[_Side, int] = {}
        self._taken: set[int] = set()
        for k, piece in enumerate(pieces):
            for i, side in enumerate(_sides(piece)):
                self._owner[side] = k
                self._before[side] = piece[i - 1]
                self._after[side] = piece[(i + 2) % len(piece)]

    def is_taken(self, k: int) -> bool:
        """Return whether another piece has taken in this one."""
        return k in self._taken

    def grow(self, k: int) -> list[int]:
        """Let a piece take in its neighbours, and return its corners. Pieces grow in their order."""
        due = deque(_sides(self._pieces[k]))
        seam: _Side | None = None
        while due:
            a, b = due.popleft()
            other = self._owner.get((b, a), k)
            if other <= k or other in self._taken or not self._fits(a, b):
                continue
            seam = (b, self._join(a, b))
            self._taken.add(other)
            there = self._pieces[other]
            at = there.index(a)
            due.extend(_sides(there[at:] + there[:at])[:-1])
        return self._pieces[k] if seam is None else self._around(seam)

    def _fits(self, a: int, b: int) -> bool:
        """Return whether two pieces, joined along a side, turn left, or go on, at both of its ends."""
        ring, before, after = self._ring, self._before, self._after
        return (
            orientation(ring[before[b, a]], ring[b], ring[after[a, b]]) >= 0
            and orientation(ring[before[a, b]], ring[a], ring[after[b, a]]) >= 0
        )

    def _join(self, a: int, b: int) -> int:
        """Join two pieces along a side; return the corner that follows the end of the side."""
        before, after = self._before, self._after
        into, out = before[a, b], after[b, a]
        after[into, a], before[a, out] = out, into
        into, out = before[b, a], after[a, b]
        after[into, b], before[b, out] = out, into
        for side in ((a, b), (b, a)):
            del self._owner[side]
        return out

    def _around(self, first: _Side) -> list[int]:
        """Return the corners of the piece with a side, beginning with that side."""
        corners = [first[0]]
        a, b = first
        while b != first[0]:
            corners.append(b)
            a, b = b, self._after[a, b]
        return corners


def _sides(piece: list[int]) -> list[_Side]:
    return list(zip(piece, [*piece[1:], piece[0]], strict=True))
