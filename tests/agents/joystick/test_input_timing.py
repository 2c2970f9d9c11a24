"""When a state is sent: at once when it changes, 20 times a second while held, three zeros after a release."""

from __future__ import annotations

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.input_timing import InputTiming
from intellwheels_schemas.messages import UserInput

AHEAD = InputState(forward=0.5, buttons=(1,), word="go")


def messages(timing: InputTiming, state: InputState, begin: float, end: float) -> list[UserInput]:
    """Return what a loop of 100 turns a second sends."""
    found = [timing.message(state, begin + 0.01 * k) for k in range(round((end - begin) / 0.01))]
    return [user for user in found if user is not None]


def test_a_held_state_is_sent_twenty_times_a_second() -> None:
    users = messages(InputTiming(), AHEAD, 0.0, 2.0)
    assert 20 <= len(users) <= 40
    assert {(user.forward, user.buttons, user.word, user.lease) for user in users} == {(0.5, (1,), "go", None)}
    assert [user.seq for user in users] == list(range(1, len(users) + 1))


def test_a_neutral_state_is_not_sent() -> None:
    assert messages(InputTiming(), NEUTRAL, 0.0, 1.0) == []


def test_a_release_is_sent_at_once_and_three_times_in_all() -> None:
    timing = InputTiming()
    messages(timing, AHEAD, 0.0, 1.0)
    first = timing.message(NEUTRAL, 1.001)
    assert first is not None
    assert (first.forward, first.buttons, first.word) == (0.0, (), None)
    assert len(messages(timing, NEUTRAL, 1.01, 3.0)) == 2


def test_a_change_is_sent_at_once_but_a_trembling_stick_is_limited() -> None:
    timing = InputTiming()
    assert timing.message(InputState(0.5), 1.0) is not None
    assert timing.message(InputState(0.6), 1.001) is None
    assert timing.message(InputState(0.6), 1.021) is not None
    assert timing.message(InputState(0.6), 1.042) is None


def test_a_source_that_ends_sends_a_last_zero_unless_it_was_neutral() -> None:
    timing = InputTiming()
    assert timing.final_message(0.0) is None
    timing.message(AHEAD, 1.0)
    last = timing.final_message(1.0)
    assert last is not None
    assert last.forward == 0.0
    assert timing.final_message(1.0) is None
