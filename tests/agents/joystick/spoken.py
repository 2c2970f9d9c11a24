"""Says words, with eSpeak NG from the package espeakng-loader. Sound is kept for the whole session."""

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


@cache
def said(word: str, voice: str = "en-us", speed: int = 150, pitch: int = 50) -> bytes:
    """Return a word as samples of 16 bits at `RATE`, with 0.7 s of silence on each side."""
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
