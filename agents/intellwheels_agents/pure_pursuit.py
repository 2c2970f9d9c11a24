"""Paths for pure pursuit: a chair steers towards the point of its path that lies a look-ahead distance in front of it.

    (x, y): that point in the body frame, L: its distance; the arc through it has curvature 2 y / L^2

Source: R. C. Coulter, Implementation of the Pure Pursuit Path Tracking Algorithm, CMU-RI-TR-92-01, 1992.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from intellwheels_agents.mind import Context
from intellwheels_agents.options import OptionError
from intellwheels_agents.portable_math import atan2, dist, hypot

Point = tuple[float, float]


class Path:
    """A polyline that is followed forwards only.

    Attributes:
        length: Length from the first point to the last, m.
        done: Length of the part that is already driven, m.
    """

    # The nearest point is looked for at most this far beyond `done`, in m, so that a path which returns along itself
    # is not cut short.
    WINDOW = 1.0

    def __init__(self, points: Sequence[Point]) -> None:
        """Take two or more points, m; of equal neighbours only one is kept.

        Raises:
            ValueError: There are fewer than two different points.
        """
        distinct: list[Point] = []
        for point in points:
            if not distinct or dist(point, distinct[-1]) > 1e-6:
                distinct.append(point)
        if len(distinct) < 2:
            raise ValueError("path: expected at least 2 different points")
        self._points = distinct
        self._starts = [0.0]
        for a, b in pairwise(distinct):
            self._starts.append(self._starts[-1] + dist(a, b))
        self.length = self._starts[-1]
        self.done = 0.0

    def extend(self, point: Point) -> None:
        """Add a point at the end, unless it equals the last one."""
        if dist(point, self._points[-1]) > 1e-6:
            self._starts.append(self._starts[-1] + dist(point, self._points[-1]))
            self._points.append(point)
            self.length = self._starts[-1]

    @property
    def end(self) -> Point:
        """The last point."""
        return self._points[-1]

    @property
    def remaining(self) -> float:
        """Length that still lies ahead, m."""
        return self.length - self.done

    def update(self, x: float, y: float) -> None:
        """Move `done` forward to the point of the path nearest to (x, y); it never moves back."""
        best, done = math.inf, self.done
        for i, (a, b) in enumerate(pairwise(self._points)):
            start, end = self._starts[i], self._starts[i + 1]
            if end < self.done or start > self.done + self.WINDOW:
                continue
            length = end - start
            along = ((x - a[0]) * (b[0] - a[0]) + (y - a[1]) * (b[1] - a[1])) / length
            along = min(max(along, self.done - start, 0.0), length, self.done + self.WINDOW - start)
            px, py = self._on(i, along)
            off = hypot(x - px, y - py)
            if off < best:
                best, done = off, start + along
        self.done = done

    def ahead(self, distance: float) -> Point:
        """Return the point `distance` m beyond `done`; past the end, on the extension of the last leg."""
        target = self.done + distance
        i = 0
        while i < len(self._points) - 2 and self._starts[i + 1] < target:
            i += 1
        return self._on(i, target - self._starts[i])

    def to_corner(self, angle: float) -> float:
        """Return the length in m to the next corner sharper than `angle` (rad), or to the end."""
        for i in range(1, len(self._points) - 1):
            if self._starts[i] <= self.done:
                continue
            a, b, c = self._points[i - 1 : i + 2]
            turn = atan2(c[1] - b[1], c[0] - b[0]) - atan2(b[1] - a[1], b[0] - a[0])
            if abs(math.remainder(turn, 2.0 * math.pi)) > angle:
                return self._starts[i] - self.done
        return self.remaining

    def _on(self, i: int, along: float) -> Point:
        (ax, ay), (bx, by) = self._points[i], self._points[i + 1]
        share = along / (self._starts[i + 1] - self._starts[i])
        return ax + share * (bx - ax), ay + share * (by - ay)


def path_of(context: Context) -> Path | None:
    """Return the path from a body's start through the points of its options; None if it is already at the end.

    Raises:
        OptionError: The options name no point, or a place that the map does not have.
    """
    points = context.route()
    if not points:
        raise OptionError("options: expected at least one of points, via and to, got none")
    try:
        return Path([(context.position.x, context.position.y), *points])
    except ValueError:
        return None
