from __future__ import annotations

import math
import random

import pytest

from intellwheels_maps.crossing import Point, orientation
from intellwheels_server.world.convex_pieces import convex_pieces


def area(corners: list[Point]) -> float:
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)) / 2.0


def comb(teeth: int) -> list[Point]:
    """A bar with teeth, anticlockwise."""
    ring: list[Point] = [(0.0, 0.0), (2.0 * teeth, 0.0)]
    for k in reversed(range(teeth)):
        ring += [(2.0 * k + 2.0, 1.0), (2.0 * k + 1.0, 1.0), (2.0 * k + 1.0, 100.0), (2.0 * k, 100.0)]
    return ring


def spiral(turns: int) -> list[Point]:
    """A long arm of constant width, anticlockwise."""
    angles = [k * 0.1 for k in range(63 * turns)]
    outer = [((1.5 + 0.2 * t) * math.cos(t), (1.5 + 0.2 * t) * math.sin(t)) for t in angles]
    inner = [((1.0 + 0.2 * t) * math.cos(t), (1.0 + 0.2 * t) * math.sin(t)) for t in angles]
    return outer + inner[::-1]


def star(count: int) -> list[Point]:
    chance = random.Random(count)
    radii = [chance.uniform(1.0, 9.0) for _ in range(count)]
    return [(r * math.cos(math.tau * k / count), r * math.sin(math.tau * k / count)) for k, r in enumerate(radii)]


@pytest.mark.parametrize("ring", [comb(500), spiral(16), star(2000)], ids=["comb", "spiral", "star"])
def test_two_thousand_corners_become_convex_pieces_that_cover_the_ring(ring: list[Point]) -> None:
    pieces = convex_pieces(ring)
    assert pieces is not None
    polygons = [[ring[i] for i in piece] for piece in pieces]
    for polygon in polygons:
        size = len(polygon)
        assert all(orientation(polygon[i - 1], polygon[i], polygon[(i + 1) % size]) >= 0 for i in range(size))
    assert sum(map(area, polygons)) == pytest.approx(area(ring), rel=1e-9)
    assert len(pieces) < 0.7 * len(ring)


def test_comb_becomes_its_teeth_and_its_bar() -> None:
    pieces = convex_pieces(comb(500))
    assert pieces is not None
    assert len(pieces) == 501


def test_convex_ring_stays_whole() -> None:
    ring = [(math.cos(k), math.sin(k)) for k in (0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)]
    assert convex_pieces(ring) == [[0, 1, 2, 3, 4, 5, 6]]
