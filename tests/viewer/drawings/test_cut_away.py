"""Walls between a camera and the body that it follows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_maps import library
from intellwheels_schemas.messages import Corner, Map, Wall
from intellwheels_viewer.drawings.cut_away import PIECE, STUB, cut_away, hidden, pieces_of

LINE = (Corner(x=-3.0, y=0.0), Corner(x=3.0, y=0.0))
FLOOR = Map(format="iw.v1", name="wall", wall=(Wall(height=2.5, thickness=0.1, corner=LINE),))
BODY = (0.0, 1.0)


def length(wall: Wall) -> float:
    a, b = wall.corner
    return math.hypot(b.x - a.x, b.y - a.y)


def test_a_wall_in_front_of_the_body_is_in_the_way_and_only_near_the_line_of_sight() -> None:
    pieces = pieces_of(FLOOR)
    assert len(pieces) == 6
    parts = hidden(pieces, (0.0, -4.0, 2.0), BODY, math.inf)
    assert parts
    assert all(abs(pieces[part, 0] + pieces[part, 2]) / 2 < 1.0 for part in parts)


@pytest.mark.parametrize("eye", [(0.0, 5.0, 2.0), (0.0, -0.5, 30.0), (9.0, 1.0, 1.0)])
def test_a_wall_behind_the_body_or_below_the_line_of_sight_is_not(eye: tuple[float, float, float]) -> None:
    assert hidden(pieces_of(FLOOR), eye, BODY, math.inf) == frozenset()


def test_a_wall_that_is_cut_low_enough_is_not_in_the_way() -> None:
    assert hidden(pieces_of(FLOOR), (0.0, -2.0, 4.0), BODY, 2.5)
    assert hidden(pieces_of(FLOOR), (0.0, -2.0, 4.0), BODY, 0.1) == frozenset()


def test_parts_are_cut_and_the_rest_of_the_wall_stands() -> None:
    cut = cut_away(FLOOR, {2, 3})
    assert [(round(length(wall), 6), wall.height) for wall in cut.wall] == [(2.0, 2.5), (2.0, STUB), (2.0, 2.5)]
    assert cut_away(FLOOR, ()) is FLOOR


@pytest.mark.parametrize("name", ["room", "ward", "crossing"])
def test_a_map_keeps_its_walls_whatever_is_cut(name: str) -> None:
    floor = library.floor(name)
    pieces = pieces_of(floor)
    lengths = np.hypot(pieces[:, 2] - pieces[:, 0], pieces[:, 3] - pieces[:, 1])
    assert len(pieces) == 0 or lengths.max() <= PIECE + 1e-9
    cut = cut_away(floor, range(0, len(pieces), 3))
    after = pieces_of(cut)
    assert np.hypot(after[:, 2] - after[:, 0], after[:, 3] - after[:, 1]).sum() == pytest.approx(lengths.sum())


def test_polygons_are_left_alone() -> None:
    ring = tuple(Corner(x=x, y=y) for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)))
    assert len(pieces_of(Map(format="iw.v1", name="p", wall=(Wall(corner=ring),)))) == 0
