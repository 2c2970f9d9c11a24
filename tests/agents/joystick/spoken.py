"""Says words, with eSpeak NG from the package espeakng-loader. Sound is kept for the whole session.

The sound of a word depends on all that eSpeak said before it in this process. So all words are said at once, in one
order, at the first call: then they sound the same whatever the order of the tests.
"""

from __future__ import annotations

import array
import ctypes
from functools import cache
from typing import Any

import pytest

RATE = 16000
"""Samples a second of what is said."""
_RETRIEVAL, _SPEED, _PITCH, _UTF8 = 1, 1, 3, 1  # from speak_lib.h
_CALLBACK = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.c_void_p)


@cache
def _library() -> tuple[Any, int]:
    loader = pytest.importorskip("espeakng_loader", reason="saying words needs the package espeakng-loader")
    library = ctypes.CDLL(loader.get_library_path())
    rate = library.espeak_Initialize(_RETRIEVAL, 0, loader.get_data_path().encode(), 0)
    if rate <= 0:
        pytest.skip("eSpeak NG does not start")
    return library, rate


VOICES = (("en-us", 150, 50), ("en-us", 130, 30), ("en-gb", 150, 50), ("en-us", 170, 70))
"""Voices with their speed in words a minute and their pitch from 0 to 99. The first says the words of `OTHERS` too."""
COMMANDS = ("forward", "left", "right", "stop", "reverse")
OTHERS = ("hello", "kitchen", "please", "morning", "water", "table", "seven", "weather", "today")


def said(word: str, voice: tuple[str, int, int] = VOICES[0]) -> bytes:
    """Return a word as samples of 16 bits at `RATE`, with 0.7 s of silence on each side.

    Raises:
        KeyError: The word or the voice is none of those above.
    """
    return _sounds()[word, voice]


@cache
def _sounds() -> dict[tuple[str, tuple[str, int, int]], bytes]:
    wanted = [(word, voice) for voice in VOICES for word in COMMANDS] + [(word, VOICES[0]) for word in OTHERS]
    return {(word, voice): _synthesized(word, *voice) for word, voice in wanted}


def _synthesized(word: str, voice: str, speed: int, pitch: int) -> bytes:
    library, rate = _library()
    sound = bytearray()

    def take(samples: Any, count: int, _events: Any) -> int:
        sound.extend(ctypes.string_at(samples, 2 * count) if samples and count > 0 else b"")
        return 0

    callback = _CALLBACK(take)
    library.espeak_SetSynthCallback(callback)
    library.espeak_SetVoiceByName(voice.encode())
    library.espeak_SetParameter(_SPEED, speed, 0)
    library.espeak_SetParameter(_PITCH, pitch, 0)
    text = word.encode()
    library.espeak_Synth(text, len(text) + 1, 0, 0, 0, _UTF8, None, None)
    library.espeak_Synchronize()
    heard = array.array("h", bytes(sound))
    silence = bytes(2 * int(0.7 * RATE))
    # The nearest sample is good enough for a recogniser.
    resampled = array.array("h", [heard[int(k * rate / RATE)] for k in range(int(len(heard) * RATE / rate))])
    return silence + resampled.tobytes() + silence
