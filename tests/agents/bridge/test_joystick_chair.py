from __future__ import annotations

import pytest

from intellwheels_agents.bridge.joystick_chair import JoystickChair
from intellwheels_agents.bridge.timeouts import CONTROLLER_WATCHDOG


def test_it_rolls_as_the_joystick_says_and_stops_by_its_watchdog() -> None:
    chair = JoystickChair(1.0)
    for _ in range(200):
        chair.command(0.5, 0.1)
        chair.step(0.01)
    # For 2 s, less the lag: left 0.4, right 0.6 m/s.
    assert chair.travel == pytest.approx([0.4 * 1.9, 0.6 * 1.9], abs=0.01)
    for _ in range(30):
        chair.step(0.01)
    assert chair.stick == (0.0, 0.0)
    powered, moving, stopped = chair.take_messages()
    assert (powered, moving) == ("powered ms=0", "moving ms=0")
    silence = int(stopped.partition("silence=")[2])
    assert 1000 * CONTROLLER_WATCHDOG <= silence <= 1000 * CONTROLLER_WATCHDOG + 10
    assert chair.take_messages() == []


def test_a_command_of_rest_stops_it_at_once() -> None:
    chair = JoystickChair(1.0)
    chair.command(1.0, 0.0)
    chair.step(0.01)
    chair.command(0.0, 0.0)
    assert chair.take_messages()[-1] == "stopped ms=10 silence=-1"
