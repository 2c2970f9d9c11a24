"""A wish is a value; the hand is off only when nothing at all is wanted."""

from __future__ import annotations

import pytest

from intellwheels_agents.joystick.wish import NOTHING, Wish


def test_wishes_that_say_the_same_are_the_same() -> None:
    assert Wish(0.5, -0.5, (1,), "stop") == Wish(forward=0.5, turn=-0.5, buttons=(1,), word="stop")
    assert Wish() == NOTHING


@pytest.mark.parametrize("wish", [Wish(forward=1e-9), Wish(turn=-1.0), Wish(buttons=(0,)), Wish(word="")])
def test_whoever_wants_anything_has_a_hand_on_it(wish: Wish) -> None:
    assert not wish.is_nothing


def test_a_stick_in_the_middle_is_a_hand_that_is_off() -> None:
    assert Wish(0.0, -0.0).is_nothing
    assert NOTHING.is_nothing
