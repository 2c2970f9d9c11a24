"""Sips and puffs as keys."""

from __future__ import annotations

import pytest

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.sip_and_puff import DEFAULT_KEYS, SipAndPuff


def switch(*, latch: bool = False) -> SipAndPuff:
    made = SipAndPuff(DEFAULT_KEYS, 0.8, 0.4, latch=latch, hold=2.0)
    made.read((), 0.0)
    return made


@pytest.mark.parametrize(
    ("held", "state"),
    [
        ("up", InputState(0.8)),
        ("down", InputState(-0.8)),
        ("right", InputState(turn=-0.4)),
        ("left", InputState(turn=0.4)),
        ("up left", InputState(0.8, 0.4)),
        ("x", NEUTRAL),
        ("", NEUTRAL),
    ],
)
def test_a_signal_drives_while_it_lasts(held: str, state: InputState) -> None:
    assert switch().read(held.split(), 0.1) == state


def test_keys_are_chosen_by_the_user() -> None:
    made = SipAndPuff({**DEFAULT_KEYS, "hard-puff": "f1"}, 1.0, 1.0, latch=False, hold=2.0)
    assert made.read({"f1"}, 0.1) == InputState(1.0)
    assert made.read({"up"}, 0.2) == NEUTRAL
    assert "f1 is hard-puff" in made.help[0]


def times(made: SipAndPuff, begin: float, end: float, *held: str) -> InputState:
    """Read 20 times a second from one time to another."""
    state = NEUTRAL
    for number in range(round((end - begin) / 0.05)):
        state = made.read(held, begin + 0.05 * (number + 1))
    return state


def test_a_latched_puff_drives_until_a_hard_sip_which_does_not_drive_back() -> None:
    made = switch(latch=True)
    assert times(made, 0.0, 0.2, "up") == InputState(0.8)
    assert times(made, 0.2, 1.0) == InputState(0.8)
    assert times(made, 1.0, 1.2, "left") == InputState(0.8, 0.4)
    assert times(made, 1.2, 1.5, "down") == NEUTRAL
    assert times(made, 1.5, 2.25) == NEUTRAL
    assert times(made, 2.25, 2.4, "down") == InputState(-0.8)
    assert times(made, 2.4, 2.6) == NEUTRAL


def test_a_hard_sip_that_a_terminal_repeats_after_a_pause_still_does_not_drive_back() -> None:
    made = switch(latch=True)
    times(made, 0.0, 0.2, "up")
    for begin in (0.2, 0.85, 1.5):
        assert times(made, begin, begin + 0.3, "down") == NEUTRAL
        assert times(made, begin + 0.3, begin + 0.65) == NEUTRAL
    assert times(made, 2.15, 2.3, "up") == InputState(0.8)


def test_a_latch_ends_after_its_time_and_a_signal_prolongs_it() -> None:
    made = switch(latch=True)
    times(made, 0.0, 0.2, "up")
    assert times(made, 0.2, 2.0) == InputState(0.8)
    assert "hard sip stops" in made.caption
    assert times(made, 2.0, 2.1, "right") == InputState(0.8, -0.4)
    assert times(made, 2.1, 4.0) == InputState(0.8)
    assert times(made, 4.0, 4.2) == NEUTRAL
    assert "hard puff" in made.caption


def test_silence_ends_a_latch() -> None:
    made = switch(latch=True)
    times(made, 0.0, 0.2, "up")
    assert made.read((), 1.0) == NEUTRAL
