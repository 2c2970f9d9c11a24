"""Words from sound, with PocketSphinx and a grammar. Sound in, words out; the only file that knows PocketSphinx.

The words are forward, reverse, left, right and stop. `reverse` means back, because it is recognised more surely. A word
counts when the speech around it has ended. `stop` counts as soon as the recogniser believes it, because stopping by
mistake does no harm. Speech that lasts longer than a word gives nothing. The grammar also has common words, because
with the five alone every second word of a talk would drive; with them it is one in twenty. Whoever talks in the room
must expect that the chair moves for the time of `--hold`.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from intellwheels_agents.joystick.pygame_source import DeviceError
from intellwheels_agents.joystick.words_source import SAID
from intellwheels_schemas.extras import missing_extra

OTHERS: Final = (
    "a | bad | better | bring | can | could | door | eye | find | get | great | he | here | house | in | know | let | "
    "little | make | mean | more | my | not | off | open | out | phone | read | say | should | sleep | soon | such | "
    "ten | then | think | to | up | walk | we | which | why | word | year"
)
"""Words that are recognised to be ignored: every fourth of the most common, without those that sound like ours."""
OTHERS_WEIGHT: Final = 1e-20
"""Weight of each of them. Of 20 synthesized commands in four voices all are recognised. Of 200 other words in these
voices, none of them in the grammar, 9 are taken for stop and 12 for another command: room, happy, lunch, light and
dark. The recogniser adapts to what it hears, so after noise it is other words. With weight 1 three commands are missed.
"""
GRAMMAR: Final = (
    "#JSGF V1.0; grammar drive; public <word> = "
    + " | ".join(f"/1/ {word}" for word in ("forward", "reverse", "left", "right", "stop"))
    + "".join(f" | /{OTHERS_WEIGHT:g}/ {word}" for word in OTHERS.split(" | "))
    + ";"
)
STOP_FRAMES: Final = 4
"""Frames of 30 ms for which the recogniser must believe `stop` before it counts in the middle of speech."""
RATES: Final = (16000, 48000)
"""Lowest and highest number of samples a second that the acoustic model takes."""
MAX_SPEECH: Final = 3.0
"""Seconds of speech without a pause after which it is no word but talk or noise."""


class Spoken(NamedTuple):
    """A word that was said.

    Attributes:
        word: A word of the contract.
        age: Seconds of sound that has arrived since the word ended, or since `stop` was believed before its end.
    """

    word: str
    age: float


class MissingPocketsphinxError(DeviceError):
    """The extra `voice` is not installed."""


class WordRecogniser:
    """Recognises words in sound that arrives in pieces.

    Args:
        rate: Samples a second, in `RATES`.

    Raises:
        MissingPocketsphinxError: PocketSphinx is not installed.
        DeviceError: The rate is out of range.
    """

    def __init__(self, rate: int) -> None:
        lacking = missing_extra("voice")
        if lacking is not None:
            raise MissingPocketsphinxError(f"--source voice: {lacking}")
        if not RATES[0] <= rate <= RATES[1]:
            raise DeviceError(f"--source voice: expected {RATES[0]} to {RATES[1]} samples a second, got {rate}")
        import pocketsphinx  # noqa: PLC0415

        pocketsphinx.set_loglevel("FATAL")
        self.rate = rate
        self._decoder: Any = pocketsphinx.Decoder(samprate=rate, lm=None)
        self._decoder.add_jsgf_string("drive", GRAMMAR)
        self._decoder.activate_search("drive")
        self._endpointer: Any = pocketsphinx.Endpointer(sample_rate=rate)
        self._frame = self._endpointer.frame_bytes
        self._rest = b""
        self._heard = 0.0
        self._speech = self._stops = 0
        self._is_in_speech = self._has_stopped = self._is_too_long = False

    def feed(self, data: bytes) -> list[Spoken]:
        """Return the words that have become known.

        Args:
            data: The next samples: signed 16 bits, little-endian, one channel. A sample may be cut between two pieces.
        """
        spoken = self._words(data)
        # Of a piece that is long, because it had to wait, the first words are old.
        return [Spoken(word, age + self._heard - at) for word, age, at in spoken]

    def end(self) -> list[Spoken]:
        """Return the last words: the sound has ended, and silence follows."""
        return [Spoken(word, age) for word, age, _ in self._words(bytes(2 * self.rate))]

    def _words(self, data: bytes) -> list[tuple[str, float, float]]:
        """Return words with their age when they became known, and the seconds of sound until then."""
        self._rest += data
        spoken = []
        whole = len(self._rest) - len(self._rest) % self._frame
        for begin in range(0, whole, self._frame):
            word = self._hear(self._rest[begin : begin + self._frame])
            if word is not None:
                spoken.append((*word, self._heard))
        self._rest = self._rest[whole:]
        return spoken

    def _hear(self, frame: bytes) -> Spoken | None:
        speech = self._endpointer.process(frame)
        self._heard += len(frame) / (2 * self.rate)
        if speech is None:
            return None
        if not self._is_in_speech:
            self._decoder.start_utt()
            self._speech = self._stops = 0
            self._is_in_speech, self._has_stopped, self._is_too_long = True, False, False
        self._speech += len(speech)
        # Of speech that lasts, no more than a word's length is decoded.
        self._is_too_long = self._speech > 2 * self.rate * MAX_SPEECH
        if not self._is_too_long:
            self._decoder.process_raw(speech)
        if self._endpointer.in_speech:
            return self._stops_already()
        self._is_in_speech = False
        self._decoder.end_utt()
        hypothesis = self._decoder.hyp()
        word = None if hypothesis is None or self._is_too_long else SAID.get(hypothesis.hypstr)
        if word is None or (word == "stop" and self._has_stopped):
            return None
        return Spoken(word, max(0.0, self._heard - self._endpointer.speech_end))

    def _stops_already(self) -> Spoken | None:
        if self._has_stopped or self._is_too_long:
            return None
        hypothesis = self._decoder.hyp()
        self._stops = self._stops + 1 if hypothesis is not None and hypothesis.hypstr == "stop" else 0
        if self._stops < STOP_FRAMES:
            return None
        self._has_stopped = True
        return Spoken("stop", 0.0)
