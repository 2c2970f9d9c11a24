"""When an input state is sent.

state                      sent
changed                    at once, but not within 20 ms of the last
unchanged, not neutral     20 times a second
neutral again              at once, and twice more, because a message may be lost
neutral                    nothing, so that another joystick can drive the same chair
"""

from __future__ import annotations

from typing import Final

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_schemas.messages import UserInput

REPEAT_PERIOD: Final = 0.05
"""Seconds between repetitions: a tick at 20 Hz, a sixth of the silence that stops a chair."""
MIN_PERIOD: Final = 0.02
"""Shortest time between messages of a changing state, in seconds. A stick trembles faster than that."""
RELEASE_MESSAGES: Final = 3
"""Number of neutral messages after a release."""


class InputTiming:
    """Turns input states into `UserInput` messages."""

    def __init__(self) -> None:
        self._last = NEUTRAL
        self._sent = -1.0
        self._releases = 0
        self._seq = 0

    def message(self, state: InputState, now: float) -> UserInput | None:
        """Return the message to send now, or None.

        Args:
            state: The input now.
            now: Seconds of the monotonic clock.
        """
        released = state.is_neutral and not self._last.is_neutral
        if released:
            self._releases = RELEASE_MESSAGES
        # A message may go out a millisecond early: if a wait ends a little short, it would cost a whole period.
        is_due = now - self._sent >= (REPEAT_PERIOD - 1e-3 if state == self._last else MIN_PERIOD)
        if not released and (not is_due or (state.is_neutral and not self._releases)):
            return None
        if state.is_neutral:
            self._releases -= 1
        return self._message(state, now)

    def final_message(self, now: float) -> UserInput | None:
        """Return the last message of a source that ends, or None when the chair was released before."""
        if self._last.is_neutral and not self._releases:
            return None
        self._releases = 0
        return self._message(NEUTRAL, now)

    def _message(self, state: InputState, now: float) -> UserInput:
        self._last, self._sent = state, now
        self._seq += 1
        return UserInput(seq=self._seq, forward=state.forward, turn=state.turn, buttons=state.buttons, word=state.word)
