"""States of held keys and of a stick."""

from __future__ import annotations

import pytest

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.key_bindings import DEAD_ZONE, from_keys, from_stick, without_dead_zone


@pytest.mark.parametrize(
    ("held", "state"),
    [
        ("", NEUTRAL),
        ("up", InputState(0.8, 0.0)),
        ("w d", InputState(0.8, -0.4)),
        ("down left", InputState(-0.8, 0.4)),
        ("up down", NEUTRAL),
        ("i", InputState(0.8)),
        ("k j", InputState(-0.8, 0.4)),
        ("l", InputState(turn=-0.4)),
        ("u", InputState(0.8, 0.4)),
        ("e", InputState(0.8, -0.4)),
        ("w q", InputState(0.8, 0.4)),
        ("up w", InputState(0.8)),
        ("up shift", InputState(0.4)),
        ("up left space", NEUTRAL),
        ("9 0 x", InputState(buttons=(0, 9))),
    ],
)
def test_held_keys(held: str, state: InputState) -> None:
    assert from_keys(set(held.split()), 0.8, 0.4) == state


@pytest.mark.parametrize(
    ("x", "y", "state"),
    [
        (0.0, -1.0, InputState(0.8, 0.0)),
        (1.0, 0.0, InputState(0.0, -0.4)),
        (-1.0, 1.0, InputState(-0.8, 0.4)),
        (0.1, -0.1, NEUTRAL),
    ],
)
def test_stick_ahead_is_forward_and_left_is_positive(x: float, y: float, state: InputState) -> None:
    assert from_stick(lambda number: (x, y)[number], [], 0.8, 0.4) == state


def test_only_buttons_of_the_contract_are_sent_in_order() -> None:
    assert from_stick(lambda _: 0.0, [70, 5, 2], 1.0, 1.0).buttons == (2, 5)


def test_an_axis_grows_from_the_edge_of_its_dead_zone_to_one() -> None:
    assert without_dead_zone(DEAD_ZONE) == without_dead_zone(-DEAD_ZONE) == 0.0
    assert without_dead_zone(1.0) == without_dead_zone(1.00003) == 1.0
    assert without_dead_zone(-1.0) == -1.0
    assert 0.0 < without_dead_zone(DEAD_ZONE + 0.02) < 0.05
    assert without_dead_zone(0.501) == without_dead_zone(0.502)
