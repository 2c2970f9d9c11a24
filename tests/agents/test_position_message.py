"""The message with an agent's position."""

from __future__ import annotations

import pytest

from intellwheels_agents.position_message import position_in, position_message


@pytest.mark.parametrize(
    ("text", "point"),
    [
        ("at 1.5 -2.25", (1.5, -2.25)),
        ("at 3 4", (3.0, 4.0)),
        ("at 1e3 2", None),
        ("at nan 2", None),
        ("look at 1 2", None),
        ("at 1 2 3", None),
        ("", None),
    ],
)
def test_only_a_position_message_is_a_position(text: str, point: tuple[float, float] | None) -> None:
    assert position_in(text) == point


def test_position_survives_the_message_up_to_its_decimals() -> None:
    assert position_in(position_message(1.23456, -7.0, 3)) == (1.235, -7.0)
