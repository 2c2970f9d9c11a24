"""What held keys and a stick want."""

from __future__ import annotations

import pytest

from intellwheels_agents.joystick.key_bindings import DEAD_ZONE, eased, of_keys, of_stick
from intellwheels_agents.joystick.wish import NOTHING, Wish


@pytest.mark.parametrize(
    ("held", "wish"),
    [
        ("", NOTHING),
        ("up", Wish(0.8, 0.0)),
        ("w d", Wish(0.8, -0.4)),
        ("down left", Wish(-0.8, 0.4)),
        ("up down", NOTHING),
        ("up w", Wish(0.8)),
        ("up shift", Wish(0.4)),
        ("up left space", NOTHING),
        ("9 0 x", Wish(buttons=(0, 9))),
    ],
)
def test_held_keys(held: str, wish: Wish) -> None:
    assert of_keys(set(held.split()), 0.8, 0.4) == wish


@pytest.mark.parametrize(
    ("x", "y", "wish"),
    [(0.0, -1.0, Wish(0.8, 0.0)), (1.0, 0.0, Wish(0.0, -0.4)), (-1.0, 1.0, Wish(-0.8, 0.4)), (0.1, -0.1, NOTHING)],
)
def test_a_stick_ahead_is_forward_and_to_the_left_is_positive(x: float, y: float, wish: Wish) -> None:
    assert of_stick(lambda number: (x, y)[number], [], 0.8, 0.4) == wish


def test_buttons_are_those_the_wire_takes_in_order() -> None:
    assert of_stick(lambda _: 0.0, [70, 5, 2], 1.0, 1.0).buttons == (2, 5)


def test_an_axis_grows_from_the_edge_of_its_dead_zone_to_one() -> None:
    assert eased(DEAD_ZONE) == eased(-DEAD_ZONE) == 0.0
    assert eased(1.0) == eased(1.00003) == 1.0
    assert eased(-1.0) == -1.0
    assert 0.0 < eased(DEAD_ZONE + 0.02) < 0.05
    assert eased(0.501) == eased(0.502)
