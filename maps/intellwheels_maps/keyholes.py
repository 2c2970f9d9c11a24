"""Rings with holes: a polygon whose holes are joined to the outline by edges that are traversed once in each direction.

This is the usual way to write a hole in one ring, a keyhole: A, round the outside, A, B, round the hole, B. Everything
is decided exactly.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from intellwheels_maps.crossing import Point, find_crossing, orientation


def find_fault(points: Sequence[Point]) -> tuple[int, int] | None:
    """Return two edges of a ring that touch and must not, or None if the ring is a polygon, perhaps with keyholes.

    Args:
        points: The corners of the ring, finite, each different from the next. Edge i leads from corner i to the next.
    """
    found = find_crossing(points)
    if found is not None or len(set(points)) == len(points) or is_keyhole(points):
        return found
    seen: dict[Point, int] = {}
    for corner, point in enumerate(points):
        if point in seen:
            return seen[point], corner
        seen[point] = corner
    return None


def is_keyhole(points: Sequence[Point]) -> bool:
    """Return whether a ring that comes back to some of its corners goes round an outside and round holes in it.

    Args:
        points: The corners of the ring, each different from the next. Its edges cross nowhere.
    """
    loops, bridges = _loops(points)
    counts = Counter(points)
    if not loops or any(counts[corner] < 2 for bridge in bridges for corner in bridge):
        return False  # a bridge that leads to no hole is a spike
    outside = min(loops, key=min)
    holes = [loop for loop in loops if loop is not outside]
    turn = _turn(outside)
    return all(
        _turn(hole) == -turn
        and _holds(outside, hole)
        and not any(_holds(other, hole) for other in holes if other is not hole)
        for hole in holes
    )


def _loops(points: Sequence[Point]) -> tuple[list[list[Point]], list[list[Point]]]:
    """Return the loops of a ring in which no corner comes twice, and the pairs of corners that it joins twice."""
    path: list[Point] = []
    places: dict[Point, int] = {}
    found: list[list[Point]] = []
    for point in points:
        at = places.get(point)
        if at is None:
            places[point] = len(path)
            path.append(point)
            continue
        found.append(path[at:])
        for passed in path[at + 1 :]:
            del places[passed]
        del path[at + 1 :]
    found.append(path)
    return [loop for loop in found if len(loop) > 2], [loop for loop in found if len(loop) == 2]


def _turn(loop: Sequence[Point]) -> int:
    """Return 1 if a loop is anticlockwise, -1 if it is clockwise. Its lowest leftmost corner turns as the loop does."""
    at = loop.index(min(loop))
    return orientation(loop[at - 1], loop[at], loop[(at + 1) % len(loop)])


def _holds(outer: Sequence[Point], inner: Sequence[Point]) -> bool:
    """Return whether a loop lies inside another one that it does not cross. They may share corners."""
    shared = set(outer)
    free = next((corner for corner in inner if corner not in shared), None)
    return free is not None and _is_inside(outer, free)


def _is_inside(loop: Sequence[Point], point: Point) -> bool:
    """Return whether a line from a point to the right crosses a loop an odd number of times. The point is not on it."""
    inside = False
    for a, b in zip(loop, [*loop[1:], loop[0]], strict=True):
        low, high = (a, b) if a[1] < b[1] else (b, a)
        if low[1] <= point[1] < high[1] and orientation(low, high, point) > 0:
            inside = not inside
    return inside
