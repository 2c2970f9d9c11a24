"""Of two chairs in each other's way one gives way, by name; one that has arrived always does."""

from __future__ import annotations

import pytest

from intellwheels_agents.navigation.right_of_way import FORGET, RightOfWay, way_in, way_message
from intellwheels_schemas.messages import Heard

WAY = [(0.1 * i, -1.0) for i in range(40)]


def heard(sender: str, text: str) -> Heard:
    return Heard(sender=sender, tick=1, distance=1.0, text=text)


def test_way_is_said_and_understood() -> None:
    text = way_message(WAY, 100)
    assert len(text) <= 100
    assert text.startswith("way 0.0 -1.0 0.6 -1.0 1.2 -1.0")
    assert way_in(text)[:2] == [(0.0, -1.0), (0.6, -1.0)]
    assert len(way_message(WAY, 30)) <= 30


@pytest.mark.parametrize("text", ["way", "way 1.0", "at 1.0 2.0", "open", "way 1.0 x"])
def test_other_messages_are_no_ways(text: str) -> None:
    assert way_in(text) == []


@pytest.mark.parametrize(
    ("name", "stalled", "arrived", "yields"),
    [
        ("chair2", True, False, True),
        ("chair2", False, False, False),
        ("chair2", False, True, True),
        ("chair0", True, False, False),
        ("chair0", False, True, True),
    ],
)
def test_who_gives_way(name: str, stalled: bool, arrived: bool, yields: bool) -> None:
    right = RightOfWay(name)
    right.update(1.0, [heard("chair1", way_message(WAY, 100))])
    assert bool(right.to_clear((1.0, -0.6), stalled, arrived)) is yields
    assert right.to_clear((1.0, 2.0), stalled, arrived) == []


def test_old_way_is_forgotten() -> None:
    right = RightOfWay("chair2")
    right.update(1.0, [heard("chair1", way_message(WAY, 100))])
    right.update(1.1 + FORGET, [])
    assert right.to_clear((1.0, -0.6), True, False) == []
