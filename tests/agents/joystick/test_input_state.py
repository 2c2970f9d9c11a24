from __future__ import annotations

import pytest

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState


@pytest.mark.parametrize(
    "state", [InputState(0.1), InputState(turn=-0.1), InputState(buttons=(0,)), InputState(word="a")]
)
def test_any_input_is_not_neutral(state: InputState) -> None:
    assert not state.is_neutral
    assert NEUTRAL.is_neutral
