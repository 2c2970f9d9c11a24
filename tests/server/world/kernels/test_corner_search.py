from __future__ import annotations

import random

import numpy as np

from intellwheels_maps.crossing import orientation
from intellwheels_server.world.kernels.corner_search import corners_in_triangle


def search(points: list[tuple[float, float]], left: list[int] | None = None) -> tuple[int, list[int]]:
    marks = np.array(left or [1] * len(points), dtype=np.int64)
    inside, open_ones = corners_in_triangle(np.array(points), marks, 0, 1, 2)
    return int(inside), open_ones.tolist()


TRIANGLE = [(0.0, 0.0), (4.0, 0.0), (0.0, 4.0)]


def test_first_corner_inside_is_found() -> None:
    assert search([*TRIANGLE, (5.0, 1.0), (3.0, 3.0), (1.0, 1.0), (1.0, 2.0)]) == (5, [])


def test_clipped_corners_do_not_count() -> None:
    assert search([*TRIANGLE, (1.0, 1.0), (1.0, 2.0)], [1, 1, 1, 0, 1]) == (4, [])


def test_corners_on_the_edge_are_left_open_in_their_order() -> None:
    assert search([*TRIANGLE, (2.0, 2.0), (9.0, 9.0), (2.0, 0.0)]) == (-1, [3, 5])


def test_corners_at_the_places_of_the_triangle_do_not_count() -> None:
    assert search([*TRIANGLE, TRIANGLE[0], TRIANGLE[1], TRIANGLE[2]]) == (-1, [])


def test_many_open_corners_are_kept() -> None:
    edge = [(k / 64.0, 0.0) for k in range(1, 200)]
    assert search([*TRIANGLE, *edge]) == (-1, list(range(3, 202)))


def test_agrees_with_exact_arithmetic_wherever_it_decides() -> None:
    chance = random.Random(5)
    for _ in range(300):
        points = [(chance.randrange(8) / 3.0, chance.randrange(8) / 3.0) for _ in range(12)]
        a, b, c = points[:3]
        if orientation(a, b, c) <= 0:
            continue
        sides = [min(orientation(a, b, p), orientation(b, c, p), orientation(c, a, p)) for p in points]
        inside, open_ones = search(points)
        if inside >= 0:
            assert sides[inside] == 1
        else:
            assert {k for k in range(3, 12) if sides[k] >= 0 and points[k] not in (a, b, c)} <= set(open_ones)
