"""States of held keys and of a stick."""

from __future__ import annotations

import pytest

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.key_bindings import DEAD_ZONE, GENTLE, from_keys, from_stick, without_dead_zone
from intellwheels_viewer.panels import drive_panel, stick_input
from tests.every_case import every_case

G, F, T = GENTLE, 0.8, 0.4
"""The share of a key without shift, and shares of full forward and turn."""


@every_case(
    ("held", "state"),
    [
        ("", NEUTRAL),
        ("up", InputState(G * F, 0.0)),
        ("w d", InputState(G * F, -G * T)),
        ("down left", InputState(-G * F, G * T)),
        ("up down", NEUTRAL),
        ("i", InputState(G * F)),
        ("k j", InputState(-G * F, G * T)),
        ("l", InputState(turn=-G * T)),
        ("u", InputState(G * F, G * T)),
        ("e", InputState(G * F, -G * T)),
        ("w q", InputState(G * F, G * T)),
        ("up w", InputState(G * F)),
        ("up shift", InputState(F)),
        ("k j shift", InputState(-F, T)),
        ("up left space", NEUTRAL),
        ("9 0 x", InputState(buttons=(0, 9))),
    ],
)
def test_held_keys(held: str, state: InputState) -> None:
    assert from_keys(set(held.split()), F, T) == state


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


def test_a_key_means_in_the_terminal_what_it_means_on_the_page() -> None:
    assert GENTLE == stick_input.GENTLE
    assert "Shift for full power" in drive_panel.stick_html()
