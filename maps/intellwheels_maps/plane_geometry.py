"""Points, edges and rings in the plane. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from intellwheels_maps.crossing import Point


def edges(ring: Sequence[Point]) -> Iterator[tuple[Point, Point]]:
    """Return the edges of a ring of corners, the last one from the last corner to the first."""
    return zip(ring, [*ring[1:], ring[0]], strict=True)


def side(a: Point, b: Point, c: Point) -> float:
    """Return a positive value if c is left of the line from a to b, and 0 if c is on the line."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def contains(ring: Sequence[Point], point: Point) -> bool:
    """Return whether a point is inside a ring; on an edge the answer may be either."""
    inside = False
    x, y = point
    for (ax, ay), (bx, by) in edges(ring):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            inside = not inside
    return inside


def bounds(points: Iterable[Point]) -> tuple[float, float, float, float]:
    """Return the least and the greatest x, then the least and the greatest y of points."""
    xs, ys = zip(*points, strict=True)
    return min(xs), max(xs), min(ys), max(ys)


def is_within(box: tuple[float, float, float, float], point: Point, margin: float = 0.0) -> bool:
    """Return whether a point is in the box of some `bounds`, or at most so far beside it in x and in y."""
    left, right, below, above = box
    return left - margin <= point[0] <= right + margin and below - margin <= point[1] <= above + margin
