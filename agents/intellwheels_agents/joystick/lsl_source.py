"""A stream of Lab Streaming Layer, through pylsl. The only file that knows pylsl.

The stream is chosen by name, type or both. When it is lost, the input is neutral, and the source waits until exactly
one stream of the lost one's name and type is there: it may be the same, after the network was cut. No other takes over.
Streams are found and lost in liblsl's own threads; nothing here waits for them.
"""

from __future__ import annotations

import sys
import threading
import time
from typing import Any, Final

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.lsl_channels import ChannelError, ChannelMap, StreamInput
from intellwheels_agents.joystick.pygame_source import DeviceError
from intellwheels_schemas.explain import shown
from intellwheels_schemas.extras import missing_extra

FIND_SECONDS: Final = 5.0
"""Seconds in which a stream must be found at the start."""
OTHERS_SECONDS: Final = 1.0
"""Seconds to look for a second stream that fits."""
LIST_SECONDS: Final = 1.0
"""Seconds to look for all streams when none fits."""
POLL: Final = 0.05
"""Seconds between two looks for a stream."""
RETURN_AFTER: Final = 0.5
"""Seconds after a loss before another stream is taken: the release is sent first, because opening takes that long."""
FORGET_AFTER: Final = 1.0
"""Seconds for which a stream that is gone is still listed."""
PULL_PERIOD: Final = 0.005
"""Shortest time between two reads in seconds: a stream of 1000 Hz would otherwise cost 13% of a core (measured)."""
MAX_SAMPLES: Final = 4096
"""Samples that are read at once; only the newest counts."""
MAX_LABELS: Final = 1024
"""Labels that are read from the description of a stream."""


class MissingPylslError(DeviceError):
    """The extra `lsl` is not installed."""


def pylsl_of() -> Any:
    """Return pylsl.

    Raises:
        MissingPylslError: It is not installed.
        DeviceError: Its library cannot be loaded.
    """
    lacking = missing_extra("lsl")
    if lacking is not None:
        raise MissingPylslError(f"--source lsl: {lacking}")
    try:
        import pylsl  # noqa: PLC0415
    except (RuntimeError, OSError) as error:
        raise DeviceError(f"--source lsl: expected the library liblsl, which pylsl loads: {error}") from None
    return pylsl


class LslSource:
    """Reads a stream.

    Args:
        name: Name of the stream, or None for any.
        kind: Type of the stream, such as EEG, or None for any.
        channels: How its samples become input.
        stop: Ends a wait.
        find: Seconds in which the stream must be found.

    Raises:
        DeviceError: pylsl is missing, no stream fits, or several do.
        ChannelError: The stream lacks a channel.
    """

    def __init__(
        self,
        name: str | None,
        kind: str | None,
        channels: ChannelMap,
        stop: threading.Event,
        find: float = FIND_SECONDS,
    ) -> None:
        self._lsl = pylsl_of()
        self._channels = channels
        self._stop = stop
        wanted = {"name": name, "type": kind}
        self._wanted = " ".join(f"{field} {shown(value)}" for field, value in wanted.items() if value is not None)
        predicate = " and ".join(f"{field}={_quoted(value)}" for field, value in wanted.items() if value is not None)
        self._resolver = self._lsl.ContinuousResolver(pred=predicate, forget_after=FORGET_AFTER)
        self._clock_offset = time.monotonic() - self._lsl.local_clock()
        self._inlet: Any = None
        self._input: StreamInput | None = None
        self._uid = ""
        self._kept: tuple[str, str] | None = None
        self._lost_at = -RETURN_AFTER
        self._pulled_at = 0.0
        self._told = ""
        self._is_fresh = False
        self._find(find)

    def wait(self, seconds: float) -> None:
        """Wait for a sample, at most some seconds."""
        if self._inlet is None:
            self._stop.wait(min(seconds, POLL))
            if time.monotonic() - self._lost_at >= RETURN_AFTER:
                self._reconnect()
            return
        pause = self._pulled_at + PULL_PERIOD - time.monotonic()
        if pause > 0.0:
            self._stop.wait(min(pause, seconds))
        try:
            samples, stamps = self._inlet.pull_chunk(timeout=seconds, max_samples=MAX_SAMPLES, min_samples=1)
        except self._lsl.util.LostError:
            self._lose()
            return
        except ValueError as error:  # a text that is not UTF-8
            self._tell(f"dropped why={str(error)!r}")
            return
        now = self._pulled_at = time.monotonic()
        if samples and self._input is not None:
            self._input.add(samples[-1], stamps[-1] + self._clock_offset, now)
            if self._input.problem:
                self._tell(f"dropped why={self._input.problem!r}")

    def state(self, now: float, time: float | None) -> InputState | None:  # noqa: ARG002 - as `Source` has it
        """Return the input of the newest sample; neutral while it is stale or the stream is lost."""
        if self._input is None:
            return NEUTRAL
        is_fresh = not self._input.is_stale(now)
        if is_fresh != self._is_fresh:
            self._is_fresh = is_fresh
            self._tell("fresh" if is_fresh else "stale")
        return self._input.state(now)

    def _find(self, seconds: float) -> None:
        deadline = time.monotonic() + seconds
        while not self._resolver.results():
            if self._stop.wait(POLL):
                return
            if time.monotonic() >= deadline:
                here = self._lsl.resolve_streams(wait_time=LIST_SECONDS)
                raise DeviceError(f"--source lsl: expected a stream with {self._wanted}, got {_listed(here)}")
        if self._stop.wait(OTHERS_SECONDS):
            return
        found = self._resolver.results()
        if len(found) > 1:
            raise DeviceError(
                f"--source lsl: expected one stream with {self._wanted}, got {_listed(found)}; "
                "give --stream-name and --stream-type"
            )
        if found:
            self._connect(found[0])

    def _reconnect(self) -> None:
        # A lost stream is still listed for a while. What is listed after that is there, and may be the same stream.
        is_listed = time.monotonic() - self._lost_at < FORGET_AFTER + RETURN_AFTER
        found = [
            info
            for info in self._resolver.results()
            if (self._kept is None or self._kept == (info.name(), info.type()))
            and not (is_listed and info.uid() == self._uid)
        ]
        if len(found) == 1:
            self._connect(found[0])
        elif found:
            self._tell(f"expected one stream, got {_listed(found)}")

    def _connect(self, info: Any) -> None:
        lsl = self._lsl
        # Stamps become those of this machine's clock. Recovery is done here, where the loss can be told.
        inlet = lsl.StreamInlet(info, max_buflen=1, recover=False, processing_flags=lsl.proc_clocksync)
        labels: list[str] = []
        uses = (*self._channels.axes, *self._channels.commands)
        try:
            if any(not use.is_number for use in uses):
                labels = _labels(inlet.info(timeout=2.0))
        except (TimeoutError, lsl.util.TimeoutError, lsl.util.LostError):
            return  # It is gone already; the next look finds the next one.
        is_text = info.channel_format() == lsl.cf_string
        self._input = StreamInput(self._channels, info.channel_count(), labels, is_text=is_text)
        self._inlet, self._uid, self._is_fresh = inlet, info.uid(), False
        self._kept = info.name(), info.type()
        self._tell(f"found {_described(info)}")

    def _lose(self) -> None:
        self._inlet = None
        if self._input is not None:
            self._input.lost()
        self._is_fresh = False
        self._lost_at = time.monotonic()
        self._tell("lost")

    def _tell(self, what: str) -> None:
        # A bad stream says the same hundreds of times a second.
        if what != self._told:
            self._told = what
            print(f"iw-joystick: stream {self._wanted}: {what}", file=sys.stderr, flush=True)  # noqa: T201 - the log


def _quoted(text: str) -> str:
    """Return an XPath string. It has no escapes, so `stream_text` refuses a text with both quotes."""
    return f'"{text}"' if "'" in text else f"'{text}'"


def stream_text(text: str) -> str:
    """Return the name or type of a stream, as the type of an option.

    Raises:
        ChannelError: It is empty, too long, has control characters or both kinds of quotes.
    """
    if not text or len(text) > 256 or not text.isprintable() or ("'" in text and '"' in text):
        raise ChannelError(
            f"expected a printable text of 1 to 256 characters without both kinds of quotes, got {shown(text)}"
        )
    return text


def _described(info: Any) -> str:
    rate = info.nominal_srate()
    every = f"{rate:g} Hz" if rate else "irregular"
    # Any machine of the network can announce a stream: its texts may be long, or have control characters.
    kind = info.type()
    kind = kind if kind.isprintable() and len(kind) <= 32 else shown(kind)
    return f"{shown(info.name())} ({kind or 'no type'}, {info.channel_count()} channels, {every})"


def _listed(infos: list[Any]) -> str:
    return "; ".join(_described(info) for info in infos[:8]) + ("; ..." if len(infos) > 8 else "") or "no stream at all"


def _labels(info: Any) -> list[str]:
    """Return the labels of the channels, in order; empty for those without one."""
    labels: list[str] = []
    channel = info.desc().child("channels").child("channel")
    while not channel.empty() and len(labels) < MAX_LABELS:
        labels.append(channel.child_value("label"))
        channel = channel.next_sibling("channel")
    return labels
