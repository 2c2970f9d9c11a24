from __future__ import annotations

import math
import random
from itertools import pairwise

import pytest

from intellwheels_maps.crossing import Point, find_crossing, orientation


def side(a: Point, b: Point, c: Point) -> int:
    # Whole multiples of 2^-200 have all bits of the coordinates, so this is exact, as with fractions, but faster.
    ax, ay, bx, by, cx, cy = (int(value * 2.0**200) for value in (*a, *b, *c))
    value = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    return (value > 0) - (value < 0)


def share(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Whether two closed segments share a point, without any cleverness."""
    if side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0:
        return True
    return any(
        side(one, other, point) == 0
        and min(one[0], other[0]) <= point[0] <= max(one[0], other[0])
        and min(one[1], other[1]) <= point[1] <= max(one[1], other[1])
        for one, other, point in ((a, b, c), (a, b, d), (c, d, a), (c, d, b))
    )


def crosses(points: list[Point]) -> bool:
    """Whether any two edges touch that must not: every pair is compared."""
    edges = list(pairwise([*points, points[0]]))
    count = len(edges)
    for i in range(count):
        for j in range(i + 1, count):
            (a, b), (c, d) = edges[i], edges[j]
            if j == i + 1:
                back = side(a, b, d) == 0 and (a[0] - b[0]) * (d[0] - b[0]) + (a[1] - b[1]) * (d[1] - b[1]) > 0
            elif i == 0 and j == count - 1:
                back = side(c, a, b) == 0 and (c[0] - a[0]) * (b[0] - a[0]) + (c[1] - a[1]) * (b[1] - a[1]) > 0
            else:
                back = share(a, b, c, d)
            if back:
                return True
    return False


@pytest.mark.parametrize("size", [3, 5, 20])
def test_answer_is_that_of_comparing_every_pair(size: int) -> None:
    """On a coarse lattice, where corners lie on edges and edges on each other all the time, and on a fine one."""
    chance = random.Random(size)
    found = 0
    for _ in range(700):
        points = [(float(chance.randint(0, size)), float(chance.randint(0, size))) for _ in range(chance.randint(4, 8))]
        if len(set(points)) < len(points):
            continue
        pair = find_crossing(points)
        assert (pair is not None) == crosses(points), points
        found += pair is None
    assert found > 3


def test_edges_that_are_named_do_touch() -> None:
    chance = random.Random(1)
    for _ in range(150):
        points = [(chance.random(), chance.random()) for _ in range(chance.randint(4, 30))]
        pair = find_crossing(points)
        assert (pair is not None) == crosses(points)
        if pair is not None:
            edges = list(pairwise([*points, points[0]]))
            assert share(*edges[pair[0]], *edges[pair[1]])


def test_star_does_not_cross_until_two_corners_change_places() -> None:
    chance = random.Random(2)
    for _ in range(100):
        count = chance.randint(8, 60)
        radii = [chance.uniform(1.0, 9.0) for _ in range(count)]
        star = [(r * math.cos(math.tau * k / count), r * math.sin(math.tau * k / count)) for k, r in enumerate(radii)]
        assert find_crossing(star) is None
        star[2], star[5] = star[5], star[2]
        assert (find_crossing(star) is not None) == crosses(star)


@pytest.mark.parametrize("turned", [False, True])
def test_comb_of_many_corners_is_one_of_few_comparisons(turned: bool) -> None:
    teeth = 2500
    comb: list[Point] = [(0.0, 0.0)]
    for k in range(teeth):
        comb += [(2.0 * k, 100.0), (2.0 * k + 1.0, 100.0), (2.0 * k + 1.0, 1.0), (2.0 * k + 2.0, 1.0)]
    comb += [(2.0 * teeth, 0.0)]
    if turned:
        comb = [(y, x) for x, y in comb]
    asked = 0

    class Counted(list[Point]):
        def __getitem__(self, index: int) -> Point:  # type: ignore[override]
            nonlocal asked
            asked += 1
            return super().__getitem__(index)

    assert find_crossing(Counted(comb)) is None
    assert asked < 100 * len(comb)


def test_nearly_straight_corners_are_told_from_straight_ones() -> None:
    assert orientation((0.0, 0.0), (0.1, 0.1), (0.3, 0.3)) == 0
    assert orientation((0.0, 0.0), (0.1, 0.1), (0.3, math.nextafter(0.3, 1.0))) == 1
    assert orientation((0.0, 0.0), (1e-200, 1e-200), (2e-200, math.nextafter(2e-200, 0.0))) == -1
