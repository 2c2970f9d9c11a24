"""When a wish is put.

what is wanted          what is put
something else          at once, but not within 20 ms of the last
the same, something     20 times a second
nothing any more        at once, and twice again: a put may be lost
nothing                 nothing: another hand may be on the same chair
"""

from __future__ import annotations

from typing import Final

from intellwheels_agents.joystick.wish import NOTHING, Wish
from intellwheels_schemas.messages import UserInput

EVERY: Final = 0.05
"""Seconds between two puts of the same: a tick of a simulation at 20 Hz, a sixth of the silence that counts."""
SOONEST: Final = 0.02
"""Seconds between two puts of a wish that changes: a stick trembles faster."""
ZEROS: Final = 3
"""Puts of nothing when the hand goes off."""


class WishTiming:
    """Makes `UserInput` of wishes."""

    def __init__(self) -> None:
        self._last = NOTHING
        self._at = -1.0
        self._zeros = 0
        self._seq = 0

    def put(self, wish: Wish, now: float) -> UserInput | None:
        """Return what must be put now, or None.

        Args:
            wish: What is wanted now.
            now: Seconds of the wall.
        """
        released = wish.is_nothing and not self._last.is_nothing
        if released:
            self._zeros = ZEROS
        gone = now - self._at
        # A put may come a hair early of its time, or a wait that is a hair short costs a whole turn.
        due = gone >= (EVERY - 1e-3 if wish == self._last else SOONEST)
        if not released and (not due or (wish.is_nothing and not self._zeros)):
            return None
        if wish.is_nothing:
            self._zeros -= 1
        return self._made(wish, now)

    def off(self, now: float) -> UserInput | None:
        """Return the last put of a hand that goes, or None when it was off."""
        if self._last.is_nothing and not self._zeros:
            return None
        self._zeros = 0
        return self._made(NOTHING, now)

    def _made(self, wish: Wish, now: float) -> UserInput:
        self._last, self._at = wish, now
        self._seq += 1
        return UserInput(seq=self._seq, forward=wish.forward, turn=wish.turn, buttons=wish.buttons, word=wish.word)
