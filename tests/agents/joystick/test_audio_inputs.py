"""Sound from a file, a pipe and a microphone; PortAudio is a stand-in."""

from __future__ import annotations

import os
import sys
import threading
import time
import wave
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from intellwheels_agents.joystick.audio_inputs import QUEUED, Microphone, PipeInput, WavInput
from intellwheels_agents.joystick.pygame_source import DeviceError


def wav(path: Path, data: bytes, *, rate: int = 16000, channels: int = 1, width: int = 2) -> Path:
    with wave.open(str(path), "wb") as file:
        file.setnchannels(channels)
        file.setsampwidth(width)
        file.setframerate(rate)
        file.writeframes(data)
    return path


def test_a_file_is_played_at_its_own_speed(tmp_path: Path) -> None:
    data = bytes(range(250)) * 13  # a tenth of a second
    audio = WavInput(wav(tmp_path / "a.wav", data), threading.Event())
    began, heard = time.monotonic(), b""
    while (piece := audio.read(0.05)) is not None:
        heard += piece
    assert heard == data
    assert time.monotonic() - began >= 0.1
    assert audio.rate == 16000


def test_of_several_channels_the_first_is_heard(tmp_path: Path) -> None:
    audio = WavInput(wav(tmp_path / "a.wav", b"\1\2\3\4\5\6" * 10, channels=3, rate=44100), threading.Event())
    assert audio._data == b"\1\2" * 10
    assert audio.rate == 44100


@pytest.mark.parametrize("data", [b"", b"RIFF", b"RIFF\xff\xff\xff\xffWAVEfmt ", b"nonsense" * 100])
def test_what_is_no_sound_is_refused(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "a.wav"
    path.write_bytes(data)
    with pytest.raises(DeviceError, match=r"a\.wav: expected a WAV file of 16-bit samples, got \w"):
        WavInput(path, threading.Event())


def test_samples_of_another_width_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DeviceError, match="expected samples of 16 bits, got 8"):
        WavInput(wav(tmp_path / "a.wav", b"12", width=1), threading.Event())


def test_a_pipe_gives_what_has_arrived_until_it_ends() -> None:
    reading, writing = os.pipe()
    audio = PipeInput(reading, 16000)
    assert audio.read(0.0) == b""
    os.write(writing, b"abc")
    assert audio.read(5.0) == b"abc"
    # What waited, such as while this process was stopped, comes at once: the recogniser then knows how old it is.
    os.write(writing, bytes(60_000))
    assert audio.read(5.0) == bytes(60_000)
    os.close(writing)
    assert audio.read(5.0) is None
    os.close(reading)


class PortAudioError(Exception):
    pass


class Stream:
    """A microphone that hears what the test says."""

    def __init__(self, *, callback: Callable[..., None], **settings: Any) -> None:
        self.hear = callback
        self.settings = settings
        self.active = True

    def start(self) -> None:
        pass

    def close(self) -> None:
        self.active = False


def test_a_microphone_is_heard_and_old_sound_is_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(
        sys.modules, "sounddevice", SimpleNamespace(RawInputStream=Stream, PortAudioError=PortAudioError)
    )
    audio = Microphone(16000)
    assert audio._stream.settings == {"samplerate": 16000, "channels": 1, "dtype": "int16", "blocksize": 480}
    assert audio.read(0.0) == b""
    for number in range(QUEUED + 20):
        audio._stream.hear(bytes([number]), 1, None, None)
    assert audio.read(0.0) == bytes(range(20, QUEUED + 20))
    audio.close()
    assert audio.read(0.0) is None


def test_sound_is_taken_though_the_reader_empties_the_queue_meanwhile(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(
        sys.modules, "sounddevice", SimpleNamespace(RawInputStream=Stream, PortAudioError=PortAudioError)
    )
    audio = Microphone(16000)
    monkeypatch.setattr(audio._pieces, "full", lambda: True)
    audio._stream.hear(b"ab", 1, None, None)
    assert audio.read(0.0) == b"ab"


def test_no_microphone_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(**_: Any) -> Stream:
        raise PortAudioError("no default input device")

    monkeypatch.setitem(sys.modules, "sounddevice", SimpleNamespace(RawInputStream=none, PortAudioError=PortAudioError))
    with pytest.raises(DeviceError, match="--audio mic: expected a microphone, got no default input device"):
        Microphone(16000)
