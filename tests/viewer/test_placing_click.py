"""What is placed from the palette: shown first, then asked for, and red where it may not stand."""

from __future__ import annotations

import math

import pytest

from intellwheels_schemas.messages import Spawn
from intellwheels_viewer.panels.place import PALETTE
from tests.viewer.opened import Opened
from tests.viewer.wire import until

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def test_what_is_placed_is_shown_then_wished_where_the_floor_was_clicked(here: Opened) -> None:
    label = next(iter(PALETTE))
    here.page._choose(label)
    assert here.ghost()
    here.page._placing_click.turn(90.0)
    here.page._placing_click.put(2.0, 3.0)
    request = here.network.wished()
    assert isinstance(request, Spawn)
    assert request.position is not None
    assert (request.position.x, request.position.y) == (2.0, 3.0)
    assert request.position.heading == pytest.approx(math.pi / 2)
    assert request.robot.name == f"{PALETTE[label]}1"
    until(lambda: not here.ghost())


def test_what_may_not_stand_there_turns_red_and_stays_to_be_placed_elsewhere(here: Opened) -> None:
    here.network.refuses = "overlaps a wall"
    here.page._choose(next(iter(PALETTE)))
    here.page._placing_click.put(2.0, 3.0)
    until(lambda: here.page._held_ghost.ghost is not None and here.page._held_ghost.ghost.refused)


def test_a_turn_that_is_no_number_turns_nothing(here: Opened) -> None:
    here.page._choose(next(iter(PALETTE)))
    for value in (math.nan, math.inf):
        here.page._placing_click.turn(value)
    assert here.page._placing_click._heading == 0.0
    here.page._choose("no such thing")
    assert not here.ghost()
    assert here.network.asked == []


def test_nothing_is_placed_where_nothing_was_chosen(here: Opened) -> None:
    here.page._placing_click.put(2.0, 3.0)
    assert here.network.asked == []


def test_the_ghost_stands_under_the_pointer(here: Opened) -> None:
    here.page._choose(next(iter(PALETTE)))
    first = here.page._held_ghost.ghost
    here.page._placing_click.hover(0.2, -0.2)
    second = here.page._held_ghost.ghost
    assert first is not None
    assert second is not None
    assert (first.x, first.y) != (second.x, second.y)
