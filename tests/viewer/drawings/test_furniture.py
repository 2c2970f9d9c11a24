from __future__ import annotations

import math

import numpy as np
import pytest

from intellwheels_schemas.agent_colours import FIXTURES
from intellwheels_schemas.messages import Corner, Obstacle
from intellwheels_viewer.drawings.furniture import furniture


def obstacle(name: str, length: float = 2.1, width: float = 0.95, turn: float = 0.0, **fields: float) -> Obstacle:
    cos, sin = math.cos(turn), math.sin(turn)
    corners = [(-length / 2, -width / 2), (length / 2, -width / 2), (length / 2, width / 2), (-length / 2, width / 2)]
    placed = tuple(Corner(x=x * cos - y * sin, y=x * sin + y * cos) for x, y in corners)
    return Obstacle(name=name, corner=placed, **{"top": 0.6, **fields})


@pytest.mark.parametrize("name", ["room1-bed-a", "crate", "wardrobe", "table1-top", "table1-leg2", "sofa", "bathtub"])
def test_an_obstacle_is_as_large_as_it_is_whatever_it_is(name: str) -> None:
    made = furniture(obstacle(name))
    vertices = np.concatenate([each.vertices for each in made.values()])
    assert vertices.min(axis=0) == pytest.approx([-1.05, -0.475, 0.0], abs=1e-6)
    assert vertices.max(axis=0) == pytest.approx([1.05, 0.475, 0.6], abs=1e-6)


def test_a_word_within_a_word_is_no_bed() -> None:
    assert len(furniture(obstacle("bedside-lamp"))) == 2
    assert len(furniture(obstacle("ward_bed"))) == 3


@pytest.mark.parametrize("turn", [0.0, 0.7, math.pi / 2])
def test_the_pillow_lies_at_the_wall(turn: float) -> None:
    wall = (1.2 * math.cos(turn), 1.2 * math.sin(turn))
    made = furniture(obstacle("bed", turn=turn), [wall])
    white = next(each.vertices for colour, each in made.items() if min(colour) > 240)
    pillow = white[white[:, 2] > 0.5].mean(axis=0)
    assert pillow[0] * math.cos(turn) + pillow[1] * math.sin(turn) > 0.3


def test_a_bed_that_is_no_rectangle_is_a_box() -> None:
    bent = Obstacle(name="bed", top=0.5, corner=(Corner(x=0, y=0), Corner(x=1, y=0), Corner(x=0, y=1)))
    assert len(furniture(bent)) == 2


def test_tables_are_of_wood() -> None:
    assert list(furniture(obstacle("reception-desk"))) == [FIXTURES["table"]]
