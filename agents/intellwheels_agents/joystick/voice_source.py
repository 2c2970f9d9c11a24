"""Driving by voice, without a network: sound in, input states out.

A word drives for a limited time, as with `--source words`. When no sound arrives for 0.3 s, or the sound has ended that
long ago, the chair stops, because `stop` could not be heard. A word that waited too long, such as in a pipe while this
process was stopped, drives nothing; a late `stop` still stops.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Protocol

from intellwheels_agents.joystick.audio_inputs import AudioInput
from intellwheels_agents.joystick.input_state import NEUTRAL, STALE_AFTER, InputState
from intellwheels_agents.joystick.voice_words import Spoken
from intellwheels_agents.joystick.words_source import SpokenWords

MAX_AGE: Final = 1.0
"""Seconds since its end after which a word no longer drives. The pause that ends a word takes a third of a second."""


class Recogniser(Protocol):
    """Recognises words in sound, as `voice_words.WordRecogniser` does."""

    def feed(self, data: bytes) -> Sequence[Spoken]:
        """Return the words that have become known."""
        ...

    def end(self) -> Sequence[Spoken]:
        """Return the last words."""
        ...


class VoiceSource:
    """Listens until the sound ends.

    Args:
        recogniser: Finds the words.
        audio: The sound.
        spoken: What the words mean and for how long.
    """

    def __init__(self, recogniser: Recogniser, audio: AudioInput, spoken: SpokenWords) -> None:
        self._recogniser = recogniser
        self._audio = audio
        self._spoken = spoken
        self._new: list[tuple[str, float]] = []
        self._heard_at = time.monotonic()
        self._said_at: float | None = None
        self._is_stale = self._has_ended = False

    def wait(self, seconds: float) -> None:
        """Listen, at most some seconds."""
        if self._has_ended:
            time.sleep(seconds)
            return
        data = self._audio.read(seconds)
        now = time.monotonic()
        if data is None:
            self._has_ended = True
            self._note(self._recogniser.end(), now)
            self._heard_at = time.monotonic()
        elif data:
            if now - self._heard_at > STALE_AFTER:
                # This process may have been stopped too: the word from before the gap must not drive on.
                self._spoken.end()
            self._heard_at = now
            self._note(self._recogniser.feed(data), now)

    def state(self, now: float, time: float | None) -> InputState | None:  # noqa: ARG002 - as `Source` has it
        """Return the state now, or None when the sound has ended and its last word no longer counts."""
        is_stale = now - self._heard_at > STALE_AFTER
        if is_stale != self._is_stale and not self._has_ended:
            self._is_stale = is_stale
            _log("stale: no sound arrives" if is_stale else "fresh: sound arrives")
        if is_stale:
            self._spoken.end()
            # On a busy machine recognising may take that long: `stop` is still told to the mind.
            self._new = [(word, at) for word, at in self._new if word == "stop"]
            if not self._new:
                return None if self._has_ended else NEUTRAL
        for word, at in self._new:
            if now - at > MAX_AGE and word != "stop":
                _log(
                    f"dropped word={word} why='expected one of the last {MAX_AGE:g} s, got one of {now - at:.1f} s ago'"
                )
                continue
            self._spoken.add(word, now)
            self._said_at = at
            _log(f"heard word={word}")
        self._new = []
        state = replace(self._spoken.state(now), at=self._said_at)
        self._said_at = None
        return None if self._has_ended and state.is_neutral else state

    def _note(self, spoken: Sequence[Spoken], now: float) -> None:
        self._new += [(word, now - age) for word, age in spoken]


def _log(line: str) -> None:
    print(f"iw-joystick: {line}", file=sys.stderr, flush=True)  # noqa: T201 - the log
