"""Points, edges and rings in the plane. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

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
