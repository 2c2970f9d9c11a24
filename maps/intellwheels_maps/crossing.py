"""Whether the edges of a polygon cross, in time n log n, decided exactly.

A line sweeps over the corners from left to right. The edges that it cuts are kept from the lowest to the highest, and
only edges that become neighbours are compared. The first crossing is found before their order could be wrong.

Source:
    Shamos and Hoey, Geometric intersection problems, 1976.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cmp_to_key, partial
from itertools import pairwise
from typing import TypeAlias

Point: TypeAlias = tuple[float, float]

# (3 + 16 e) e with e = 2^-53; products below the second may have lost digits to underflow.
SURE = 3.3306690738754716e-16
NO_UNDERFLOW = 1e-290


def orientation(a: Point, b: Point, c: Point) -> int:
    """Return 1 if a, b, c turn left, -1 if right, 0 if they are in line. Exact.

    Source:
        Shewchuk, Adaptive precision floating-point arithmetic, 1997, for the bound above which the sign of the rounded
        value is certain.
    """
    one, other = (b[0] - a[0]) * (c[1] - a[1]), (b[1] - a[1]) * (c[0] - a[0])
    size = abs(one) + abs(other)
    if abs(one - other) > SURE * size and size > NO_UNDERFLOW:
        return 1 if one > other else -1
    # As whole numbers of the smallest unit that all six share, which is a power of two.
    ratios = [value.as_integer_ratio() for value in (*a, *b, *c)]
    unit = max(denominator for _, denominator in ratios)
    ax, ay, bx, by, cx, cy = (numerator * (unit // denominator) for numerator, denominator in ratios)
    cross = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    return (cross > 0) - (cross < 0)


def find_crossing(points: Sequence[Point]) -> tuple[int, int] | None:
    """Return two edges of a ring that touch elsewhere than at a corner of both, or that fold back on each other.

    An edge that the ring passes there and back counts once.

    Args:
        points: The corners of the ring, finite, each different from the next. Edge i leads from corner i to the next.

    Returns:
        The numbers of two such edges, the smaller one first, or None if there are none. A triangle has none.
    """
    if len(points) <= 3:
        return None
    corners: dict[Point, list[int]] = {}
    for corner in sorted(range(len(points)), key=points.__getitem__):
        corners.setdefault(points[corner], []).append(corner)
    sweep = _Sweep(points)
    for here, same in corners.items():
        found = sweep.pass_point(here, same)
        if found is not None:
            return found
    return None


class _Sweep:
    """The sweep line: the edges it cuts, by number, from the lowest to the highest."""

    def __init__(self, points: Sequence[Point]) -> None:
        self._points = points
        self._count = len(points)
        self._cut: list[int] = []

    def pass_point(self, here: Point, corners: Sequence[int]) -> tuple[int, int] | None:
        """Move the line over all corners at a point; return two edges that touch there or right of it, if any."""
        cut = self._cut
        first = self._first(lambda edge: self._above(edge, here) <= 0)
        last = self._first(lambda edge: self._above(edge, here) < 0)
        edges = [edge for corner in corners for edge in ((corner - 1) % self._count, corner)]
        for edge in cut[first:last]:
            if here not in self._ends(edge):
                return _sorted(edge, min(edges))
        begun = [edge for edge in edges if self._other(edge, here) > here]
        if len(begun) > 1:
            begun.sort(key=cmp_to_key(partial(self._order, here)))
            for one, other in pairwise(begun):
                if self._turn(here, one, other) == 0 and not self._is_bridge(here, one, other):
                    return _sorted(one, other)
            for one, other in zip(begun, begun[2:], strict=False):
                if self._turn(here, one, other) == 0:
                    return _sorted(one, other)
            begun = [edge for k, edge in enumerate(begun) if k == 0 or self._turn(here, begun[k - 1], edge) != 0]
        cut[first:last] = begun
        last = first + len(begun)
        for low in {first - 1, last - 1}:
            if 0 <= low < len(cut) - 1 and self._touch(cut[low], cut[low + 1]):
                return _sorted(cut[low], cut[low + 1])
        return None

    def _first(self, condition: Callable[[int], bool]) -> int:
        """Return the place of the first edge that fulfils a condition, which all higher ones fulfil too."""
        low, high = 0, len(self._cut)
        while low < high:
            middle = (low + high) // 2
            if condition(self._cut[middle]):
                high = middle
            else:
                low = middle + 1
        return low

    def _above(self, edge: int, point: Point) -> int:
        """Return 1 if a point is above an edge, 0 if it is on its line, -1 if it is below."""
        a, b = self._ends(edge)
        return orientation(min(a, b), max(a, b), point)

    def _turn(self, here: Point, one: int, other: int) -> int:
        """Return 1 if the second of two edges that begin at a point is above the first, -1 if it is below, else 0."""
        return orientation(here, self._other(one, here), self._other(other, here))

    def _order(self, here: Point, one: int, other: int) -> int:
        """Return -1 if the first of two edges that begin at a point is below the second, 1 if it is above, else 0."""
        return -self._turn(here, one, other)

    def _is_bridge(self, here: Point, one: int, other: int) -> bool:
        """Return whether two edges from a point are the same one, there and back."""
        same = self._other(one, here) == self._other(other, here)
        return same and self._ends(one)[0] != self._ends(other)[0]

    def _ends(self, edge: int) -> tuple[Point, Point]:
        return self._points[edge], self._points[(edge + 1) % self._count]

    def _other(self, edge: int, here: Point) -> Point:
        a, b = self._ends(edge)
        return b if a == here else a

    def _touch(self, one: int, other: int) -> bool:
        """Return whether two edges that have no corner in common share a point."""
        (a, b), (c, d) = self._ends(one), self._ends(other)
        if a in (c, d) or b in (c, d):
            return False
        c_side, d_side, a_side, b_side = (
            orientation(a, b, c), orientation(a, b, d), orientation(c, d, a), orientation(c, d, b),
        )  # fmt: skip
        if c_side * d_side < 0 and a_side * b_side < 0:
            return True
        ends = ((c_side, a, b, c), (d_side, a, b, d), (a_side, c, d, a), (b_side, c, d, b))
        return any(side == 0 and _between(start, end, point) for side, start, end, point in ends)


def _between(a: Point, b: Point, c: Point) -> bool:
    return min(a[0], b[0]) <= c[0] <= max(a[0], b[0]) and min(a[1], b[1]) <= c[1] <= max(a[1], b[1])


def _sorted(one: int, other: int) -> tuple[int, int]:
    return (one, other) if one < other else (other, one)
