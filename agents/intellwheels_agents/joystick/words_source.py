"""Wishes from words, one after another: what a voice recogniser prints, piped in.

`forward`, `back`, `left` and `right` drive, for so long only: a recogniser that hears nothing more must not drive a
chair for ever. `stop` stops at once. Every word is also put as `UserInput.Word`, for minds that know others; a word
that does not drive leaves the driving as it is, and of several that come at once each is put in its turn. A word that
drives is put at once, and no more when another did: a mind may drive by it. The end of the input, a recogniser that
died, stops at once; what waits to be put is put still.
"""

from __future__ import annotations

import os
import re
import select
import sys
from collections import deque
from typing import Final

from intellwheels_agents.joystick.wish import Wish
from intellwheels_agents.user_input import WORDS
from intellwheels_schemas.messages import WORD_PATTERN

SAID: Final = 0.3
"""Seconds a word is put at least before the next: some ticks of any simulation hear it."""
WAITING: Final = 16
"""Words that wait their turn at most; of more the oldest are dropped."""
LONGEST: Final = 4096
"""Bytes of a line that does not end; it is dropped."""
_WORD = re.compile(WORD_PATTERN)


def is_word(text: str) -> bool:
    """Return whether the wire takes it as a word."""
    return len(text) <= 64 and _WORD.fullmatch(text) is not None


class Spoken:
    """What was said, and how long it counts.

    Args:
        forward: Share of full forward that a word asks for, in [0, 1].
        turn: Share of full turn, in [0, 1].
        hold: Seconds a word drives.
    """

    def __init__(self, forward: float, turn: float, hold: float) -> None:
        self._shares = forward, turn
        self._hold = hold
        self._drive = (0.0, 0.0)
        self._drive_until = self._word_until = -1.0
        self._word: str | None = None
        self._next_at = -1.0
        self._waiting: deque[str] = deque(maxlen=WAITING)

    def hear(self, word: str, now: float) -> None:
        """Take a word; what is none is dropped."""
        word = word.lower()
        if not is_word(word):
            return
        if word not in WORDS:
            self._waiting.append(word)
            return
        self._word, self._next_at = word, now + SAID
        forward, turn = WORDS[word]
        self._drive = forward * self._shares[0], turn * self._shares[1]
        self._drive_until = now + self._hold
        self._word_until = self._drive_until if any(self._drive) else self._next_at

    def end(self) -> None:
        """Drive no more; nothing further will be said."""
        self._drive = (0.0, 0.0)
        if self._word in WORDS:
            self._word, self._next_at = None, -1.0

    def wish(self, now: float) -> Wish:
        """Return what is wanted now."""
        if self._waiting and now >= self._next_at:
            self._word = self._waiting.popleft()
            self._next_at = self._word_until = now + SAID
        forward, turn = self._drive if now < self._drive_until else (0.0, 0.0)
        return Wish(forward, turn, word=self._word if now < self._word_until else None)


class WordsSource:
    """Reads words from a file descriptor until it ends."""

    def __init__(self, spoken: Spoken, descriptor: int) -> None:
        self._spoken = spoken
        self._descriptor = descriptor
        self._rest = b""
        self._new: list[str] = []
        self._over = False

    def wait(self, seconds: float) -> None:
        """Return when something was said, at the latest after so long."""
        heard = () if self._over else (self._descriptor,)
        if not select.select(heard, (), (), seconds)[0]:
            return
        data = os.read(self._descriptor, LONGEST)
        self._over = not data
        *lines, self._rest = (self._rest + data).split(b"\n")
        if self._over:
            lines, self._rest = [*lines, self._rest], b""
        if len(self._rest) > LONGEST:
            print("dropped line=too-long", file=sys.stderr)  # noqa: T201 - the log
            self._rest = b""
        self._new += [word for line in lines for word in line.decode(errors="replace").split()]

    def wish(self, now: float, time: float | None) -> Wish | None:  # noqa: ARG002 - as `Source` has it
        """Return what is wanted, or None after the end and the last word."""
        for word in self._new:
            self._spoken.hear(word, now)
        self._new = []
        if not self._over:
            return self._spoken.wish(now)
        self._spoken.end()
        last = self._spoken.wish(now)
        return None if last.is_nothing else last
