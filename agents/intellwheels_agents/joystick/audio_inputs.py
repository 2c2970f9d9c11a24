"""Sound for `--source voice`: a WAV file, raw samples on a pipe, or a microphone. The only file that knows sounddevice.

All of them give signed 16-bit samples of one channel, little-endian. A WAV file is played at its own speed, because it
stands for a microphone.
"""

from __future__ import annotations

import os
import queue
import select
import threading
import time
import wave
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, Protocol

from intellwheels_agents.joystick.pygame_source import DeviceError

PIPE_BYTES: Final = 1 << 20
"""Bytes that are read from a pipe at once: all that a pipe of Linux can hold, so that no old sound stays in it."""
BLOCK_SECONDS: Final = 0.03
"""Seconds of sound in a piece: a frame of the recogniser."""
QUEUED: Final = 100
"""Pieces of the microphone that wait: 3 s. Older sound is dropped."""


class AudioInput(Protocol):
    """Sound that arrives.

    Attributes:
        rate: Samples a second.
    """

    rate: int

    def read(self, seconds: float) -> bytes | None:
        """Return what has arrived, waiting at most some seconds; nothing yet is empty, and None is the end."""
        ...


class WavInput:
    """A WAV file, played at its own speed. Of several channels the first is heard.

    Raises:
        DeviceError: It is no WAV file of 16-bit samples.
        OSError: It cannot be read.
    """

    def __init__(self, path: Path, stop: threading.Event) -> None:
        try:
            with wave.open(str(path), "rb") as file:
                self.rate, channels, width = file.getframerate(), file.getnchannels(), file.getsampwidth()
                data = file.readframes(file.getnframes())
        except (wave.Error, EOFError) as error:
            got = str(error) or "one that ends early"
            raise DeviceError(f"--audio {path}: expected a WAV file of 16-bit samples, got {got}") from None
        if width != 2:
            raise DeviceError(f"--audio {path}: expected samples of 16 bits, got {8 * width}")
        frame = 2 * channels
        whole = data[: len(data) - len(data) % frame]
        self._data = whole if channels == 1 else b"".join(whole[k : k + 2] for k in range(0, len(whole), frame))
        self._stop = stop
        self._given = 0
        self._began: float | None = None

    def read(self, seconds: float) -> bytes | None:
        """Return what has been played since the last call."""
        if self._began is None:
            self._began = time.monotonic()
        if self._given >= len(self._data):
            return None
        self._stop.wait(min(seconds, BLOCK_SECONDS))
        due = 2 * int(self.rate * (time.monotonic() - self._began))
        piece = self._data[self._given : due]
        self._given = max(self._given, due)
        return piece


class PipeInput:
    """Raw samples from a descriptor, as they arrive."""

    def __init__(self, descriptor: int, rate: int) -> None:
        self.rate = rate
        self._descriptor = descriptor

    def read(self, seconds: float) -> bytes | None:
        """Return what has arrived."""
        if not select.select([self._descriptor], [], [], seconds)[0]:
            return b""
        return os.read(self._descriptor, PIPE_BYTES) or None


class Microphone:
    """The standard microphone.

    Raises:
        DeviceError: There is none, or its software is missing.
    """

    def __init__(self, rate: int) -> None:
        self.rate = rate
        self._pieces: queue.Queue[bytes] = queue.Queue(QUEUED)
        try:
            import sounddevice  # noqa: PLC0415
        except OSError as error:
            raise DeviceError(
                f"--audio mic: {error}: expected PortAudio (on Debian libportaudio2); or pipe raw samples, "
                "`arecord -t raw -f S16_LE -r 16000 | iw-joystick AGENT --source voice --audio -`"
            ) from None
        try:
            self._stream: Any = sounddevice.RawInputStream(
                samplerate=rate, channels=1, dtype="int16", blocksize=round(rate * BLOCK_SECONDS), callback=self._heard
            )
            self._stream.start()
        except sounddevice.PortAudioError as error:
            raise DeviceError(f"--audio mic: expected a microphone, got {error}") from None

    def read(self, seconds: float) -> bytes | None:
        """Return what has been heard since the last call."""
        try:
            pieces = [self._pieces.get(timeout=seconds)]
        except queue.Empty:
            return b"" if self._stream.active else None
        while not self._pieces.empty():
            pieces.append(self._pieces.get_nowait())
        return b"".join(pieces)

    def close(self) -> None:
        """Close the microphone."""
        self._stream.close()

    def _heard(self, data: Any, _frames: int, _time: object, _status: object) -> None:
        """Take a piece, on a thread of PortAudio."""
        if self._pieces.full():
            with suppress(queue.Empty):  # the reader has just taken them all
                self._pieces.get_nowait()
        self._pieces.put_nowait(bytes(data))
