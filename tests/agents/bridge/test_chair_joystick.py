from __future__ import annotations

import threading

from intellwheels_agents.bridge.chair_joystick import ChairJoystick
from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from tests.agents.bridge.readings import reading


def test_the_joystick_counts_until_it_falls_silent() -> None:
    source = ChairJoystick(threading.Event())
    assert source.state(0.0, None) == NEUTRAL
    source.on_reading(reading(1, received=1.0, forward=0.5, turn=-0.2))
    assert source.state(1.29, None) == InputState(forward=0.5, turn=-0.2)
    assert source.state(1.31, None) == NEUTRAL


def test_a_released_or_missing_joystick_is_neutral() -> None:
    source = ChairJoystick(threading.Event())
    source.on_reading(reading(1, received=1.0, forward=0.01, turn=0.01))
    assert source.state(1.0, None) == NEUTRAL
    source.on_reading(reading(2, received=1.0))
    assert source.state(1.0, None) == NEUTRAL


def test_the_source_ends_when_the_process_stops() -> None:
    stop = threading.Event()
    stop.set()
    assert ChairJoystick(stop).state(0.0, None) is None
