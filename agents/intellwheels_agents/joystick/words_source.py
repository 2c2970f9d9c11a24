"""Input states from words, as a voice recogniser prints them.

`forward`, `back`, `left` and `right` drive for a limited time, because a recogniser that hears nothing more must not
drive a chair forever. `stop` stops at once. Every word is also sent as `UserInput.Word`, for minds that know others.

A word that drives is sent at once, and dropped when another driving word replaces it. Other words leave the driving
unchanged and are sent one after the other. The end of the input, such as the death of the recogniser, stops the chair
at once; the words that still wait are sent.
"""

from __future__ import annotations

import os
import re
import select
import sys
import time
from collections import deque
from dataclasses import replace
from typing import Final

from intellwheels_agents.joystick.input_state import InputState
from intellwheels_agents.user_input import WORDS
from intellwheels_schemas.messages import WORD_PATTERN

WORD_SECONDS: Final = 0.3
"""Shortest time for which a word is sent before the next one, in seconds: several ticks of any simulation get it."""
QUEUE_LENGTH: Final = 16
"""Largest number of words that wait to be sent. When more come, the oldest are dropped."""
MAX_LINE: Final = 4096
"""Bytes of the longest line; a longer one is dropped."""
SAID: Final = {**{word: word for word in WORDS}, "reverse": "back"}
"""The word of the contract for each word that a recogniser knows. `reverse` is recognised more surely than `back`."""
_WORD = re.compile(WORD_PATTERN)


def is_word(text: str) -> bool:
    """Return whether the contract accepts a text as a word."""
    return len(text) <= 64 and _WORD.fullmatch(text) is not None


class SpokenWords:
    """The words so far and what they still mean.

    Args:
        forward: Share of full forward for a word, in [0, 1].
        turn: Share of full turn, in [0, 1].
        hold: Seconds that a word drives.
    """

    def __init__(self, forward: float, turn: float, hold: float) -> None:
        self._shares = forward, turn
        self._hold = hold
        self._drive = (0.0, 0.0)
        self._drive_until = self._word_until = -1.0
        self._word: str | None = None
        self._next_at = -1.0
        self._waiting: deque[str] = deque(maxlen=QUEUE_LENGTH)

    def add(self, word: str, now: float) -> None:
        """Add a word; one that the contract does not accept is dropped."""
        word = word.lower()
        if not is_word(word):
            return
        if word not in WORDS:
            self._waiting.append(word)
            return
        forward, turn = WORDS[word]
        self._drive = forward * self._shares[0], turn * self._shares[1]
        # Nothing with a share of 0. A mind would drive by the word alone, when it comes without forward and turn.
        self._word = word if any(self._drive) or not any(WORDS[word]) else None
        self._next_at = now + WORD_SECONDS
        self._drive_until = now + self._hold
        self._word_until = self._drive_until if any(self._drive) else self._next_at

    def end(self) -> None:
        """Stop driving, because no further word will come."""
        self._drive = (0.0, 0.0)
        if self._word in WORDS:
            self._word, self._next_at = None, -1.0

    def state(self, now: float) -> InputState:
        """Return the state now."""
        if self._waiting and now >= self._next_at:
            self._word = self._waiting.popleft()
            self._next_at = self._word_until = now + WORD_SECONDS
        forward, turn = self._drive if now < self._drive_until else (0.0, 0.0)
        return InputState(forward, turn, word=self._word if now < self._word_until else None)


class WordsSource:
    """Reads words from a file descriptor until it ends."""

    def __init__(self, spoken: SpokenWords, descriptor: int) -> None:
        self._spoken = spoken
        self._descriptor = descriptor
        self._rest = b""
        self._new: list[str] = []
        self._at: float | None = None
        self._ended = False

    def wait(self, seconds: float) -> None:
        """Wait for input, at most some seconds."""
        open_inputs = () if self._ended else (self._descriptor,)
        if not select.select(open_inputs, (), (), seconds)[0]:
            return
        data = os.read(self._descriptor, MAX_LINE)
        self._at = time.monotonic()
        self._ended = not data
        *lines, self._rest = (self._rest + data).split(b"\n")
        if self._ended:
            lines, self._rest = [*lines, self._rest], b""
        if len(self._rest) > MAX_LINE:
            print("dropped line=too-long", file=sys.stderr)  # noqa: T201 - the log
            self._rest = b""
        self._new += [word for line in lines for word in line.decode(errors="replace").split()]

    def state(self, now: float, time: float | None) -> InputState | None:  # noqa: ARG002 - as `Source` has it
        """Return the state now, or None after the end of the input and the last word."""
        for word in self._new:
            self._spoken.add(word, now)
        self._new = []
        if not self._ended:
            at, self._at = self._at, None
            return replace(self._spoken.state(now), at=at)
        self._spoken.end()
        last = self._spoken.state(now)
        return None if last.is_neutral else last
