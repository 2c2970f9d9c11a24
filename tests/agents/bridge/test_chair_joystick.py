from __future__ import annotations

import threading

from intellwheels_agents.bridge.chair_joystick import StickSource
from intellwheels_agents.joystick.wish import NOTHING, Wish
from tests.agents.bridge.readings import reading


def test_the_stick_says_what_is_wanted_until_it_is_silent() -> None:
    source = StickSource(threading.Event())
    assert source.wish(0.0, None) == NOTHING
    source.hear(reading(1, arrived=1.0, forward=0.5, turn=-0.2))
    assert source.wish(1.29, None) == Wish(forward=0.5, turn=-0.2)
    assert source.wish(1.31, None) == NOTHING


def test_a_stick_at_rest_wants_nothing_and_none_is_none() -> None:
    source = StickSource(threading.Event())
    source.hear(reading(1, arrived=1.0, forward=0.01, turn=0.01))
    assert source.wish(1.0, None) == NOTHING
    source.hear(reading(2, arrived=1.0))
    assert source.wish(1.0, None) == NOTHING


def test_the_end_is_the_end() -> None:
    stop = threading.Event()
    stop.set()
    assert StickSource(stop).wish(0.0, None) is None
