from __future__ import annotations

import math
import random

import pytest

from intellwheels_maps.crossing import Point
from intellwheels_maps.keyholes import find_fault
from tests.every_case import every_case

SQUARE: list[Point] = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
HOLE: list[Point] = [(2.0, 2.0), (2.0, 8.0), (8.0, 8.0), (8.0, 2.0)]


def with_hole(outside: list[Point], hole: list[Point]) -> list[Point]:
    """Return the ring A, round the outside, A, B, round the hole, B."""
    return [*outside, outside[0], *hole, hole[0]]


def ring_round(x: float, y: float, radius: float, corners: int) -> list[Point]:
    """Return a clockwise ring."""
    turns = [-math.tau * k / corners for k in range(corners)]
    return [(x + radius * math.cos(t), y + radius * math.sin(t)) for t in turns]


KEYHOLES = {
    "hole": with_hole(SQUARE, HOLE),
    "clockwise": with_hole(SQUARE, HOLE)[::-1],
    "begun in the hole": with_hole(SQUARE, HOLE)[6:] + with_hole(SQUARE, HOLE)[:6],
    "two holes of one corner": [
        *SQUARE, SQUARE[0], (1.0, 2.0), (1.0, 4.0), (3.0, 3.0), (1.0, 2.0),
        SQUARE[0], (5.0, 2.0), (5.0, 4.0), (7.0, 3.0), (5.0, 2.0),
    ],
    "hole behind a hole": [
        *SQUARE, SQUARE[0], (2.0, 2.0), (2.0, 4.0), (4.0, 4.0), (5.0, 5.0), (5.0, 7.0), (7.0, 5.0), (5.0, 5.0),
        (4.0, 4.0), (4.0, 2.0), (2.0, 2.0),
    ],
    "bent bridge": [*SQUARE, SQUARE[0], (1.0, 5.0), (2.0, 2.0), *HOLE[1:], (2.0, 2.0), (1.0, 5.0)],
    "hole that touches the outside": [*SQUARE, SQUARE[0], (4.0, 8.0), (8.0, 4.0)],
}  # fmt: skip
NOT_POLYGONS = {
    "outward spike": [*SQUARE, SQUARE[0], (-5.0, -5.0)],
    "inward spike": [*SQUARE, SQUARE[0], (5.0, 5.0)],
    "hole the wrong way round": with_hole(SQUARE, HOLE[:1] + HOLE[:0:-1]),
    "hole outside": with_hole(SQUARE, [(-8.0, -8.0), (-8.0, -2.0), (-2.0, -2.0), (-2.0, -8.0)]),
    "two squares that touch": [*SQUARE, SQUARE[0], (-1.0, 0.0), (-1.0, -1.0), (0.0, -1.0)],
    "hole that crosses the outside": with_hole(SQUARE, [(2.0, 2.0), (2.0, 12.0), (8.0, 8.0)]),
    "hole in a hole": [
        *with_hole(SQUARE, HOLE), SQUARE[0], (1.0, 1.5), (3.0, 3.0), (3.0, 5.0), (5.0, 3.0), (3.0, 3.0), (1.0, 1.5),
    ],
    "bridge passed four times": [*with_hole(SQUARE, HOLE), SQUARE[0], HOLE[0]],
}  # fmt: skip


@pytest.mark.parametrize("name", KEYHOLES)
def test_ring_round_holes_has_no_fault(name: str) -> None:
    assert find_fault(KEYHOLES[name]) is None


@every_case("name", NOT_POLYGONS)
def test_ring_that_touches_itself_in_another_way_is_found(name: str) -> None:
    found = find_fault(NOT_POLYGONS[name])
    assert found is not None
    assert 0 <= found[0] < found[1] < len(NOT_POLYGONS[name])


def test_ring_without_holes_is_judged_as_before() -> None:
    assert find_fault(SQUARE) is None
    assert find_fault([(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]) == (0, 2)


def test_many_holes_are_taken() -> None:
    chance = random.Random(7)
    ring: list[Point] = [(0.0, 0.0)]
    for k in range(40):
        hole = ring_round(2.0 * k + 1.0, 4.0, chance.uniform(0.2, 0.9), 12)
        foot = (hole[3][0], 0.0)  # below the lowest corner
        ring += [foot, *hole[3:], *hole[:3], hole[3], foot]
    ring += [(80.0, 0.0), (80.0, 10.0), (0.0, 10.0)]
    assert find_fault(ring) is None
    assert find_fault(ring[::-1]) is None
