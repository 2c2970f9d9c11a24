"""Input states from the samples of a stream of Lab Streaming Layer. Pure: no library, and the time is an argument.

Channels are axes (`forward=0,turn=1*-0.5`), commands (`left=EMG1,stop=2`) or both. A channel is its number, from 0 on,
or its label. A value is multiplied by the factor behind `*`. An axis has a dead zone; a command is on from a threshold
up, until it falls below a second one. Commands go before axes, and stop goes before all others. In a stream of texts
the first channel has words: forward, back or reverse, left, right, stop.

The newest sample counts for 0.3 s after it was taken, by its time stamp. A sample without a finite number in a channel
that is used is dropped.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from intellwheels_agents.joystick.input_state import NEUTRAL, STALE_AFTER, InputState
from intellwheels_agents.joystick.key_bindings import DEAD_ZONE, without_dead_zone
from intellwheels_agents.joystick.words_source import SAID
from intellwheels_agents.user_input import WORDS
from intellwheels_schemas.explain import did_you_mean, shown

AXES: Final = ("forward", "turn")
"""The meanings of an axis; both are signed, turn positive to the left."""


class ChannelError(ValueError):
    """Channels that cannot be used; the text says which option, what was expected and what came."""


@dataclass(frozen=True, slots=True)
class ChannelUse:
    """What a channel of a stream means.

    Attributes:
        meaning: One of `AXES` or of `WORDS`.
        channel: Number or label of the channel.
        factor: What its values are multiplied by.
    """

    meaning: str
    channel: str
    factor: float = 1.0

    @property
    def is_number(self) -> bool:
        """Whether the channel is a number. A label that looks like one is one too."""
        return self.channel.isascii() and self.channel.isdigit() and len(self.channel) < 10


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelMap:
    """How samples become input.

    Attributes:
        axes: The channels that are axes.
        commands: The channels that are commands.
        dead_zone: Share of an axis that counts as centred.
        on: Value from which a command is on.
        off: Value below which it is off again.
        forward: Share of full forward at full deflection or for a command, in [0, 1].
        turn: The same share of full turn.
    """

    axes: tuple[ChannelUse, ...] = ()
    commands: tuple[ChannelUse, ...] = ()
    dead_zone: float = DEAD_ZONE
    on: float = 0.5
    off: float = 0.5
    forward: float = 1.0
    turn: float = 1.0


def parse_uses(text: str, option: Literal["--axes", "--commands"]) -> tuple[ChannelUse, ...]:
    """Return the uses that an option lists.

    Raises:
        ChannelError: One is wrong, or a meaning is there twice.
    """
    meanings = AXES if option == "--axes" else tuple(WORDS)
    uses: dict[str, ChannelUse] = {}
    for part in text.split(","):
        meaning, equals, rest = part.strip().partition("=")
        channel, times, factor = rest.partition("*")
        value = _finite(factor) if times else 1.0
        if not equals or not channel or meaning not in meanings or meaning in uses or not value:
            wanted = f"each of {', '.join(meanings)} at most once, as MEANING=CHANNEL or MEANING=CHANNEL*FACTOR"
            raise ChannelError(f"{option}: expected {wanted}, got {shown(part)}")
        uses[meaning] = ChannelUse(meaning, channel, value)
    return tuple(uses.values())


def parse_threshold(text: str) -> tuple[float, float]:
    """Return the values from which a command is on and below which it is off, written ON or ON,OFF.

    Raises:
        ChannelError: They are no numbers, or OFF is above ON.
    """
    on, comma, off = text.partition(",")
    high = _finite(on)
    low = _finite(off) if comma else high
    if high is None or low is None or low > high:
        raise ChannelError(f"--threshold: expected a number ON, or ON,OFF with OFF at most ON, got {shown(text)}")
    return high, low


class StreamInput:
    """What a stream has said so far.

    Args:
        channels: How samples become input.
        count: Number of channels of the stream.
        labels: Their labels, as far as the stream tells them.
        is_text: Whether its values are texts.

    Attributes:
        dropped: Number of samples that were dropped.
        problem: Why the newest sample was dropped; empty if it was not.

    Raises:
        ChannelError: The stream has no such channel, or is of the other kind.
    """

    def __init__(self, channels: ChannelMap, count: int, labels: Sequence[str], *, is_text: bool) -> None:
        if is_text and (channels.axes or channels.commands):
            raise ChannelError("--axes, --commands: expected none for a stream of texts, which are words")
        if not is_text and not (channels.axes or channels.commands):
            raise ChannelError("--axes, --commands: expected at least one for a stream of numbers, got none")
        self._channels = channels
        self._count = count
        self._is_text = is_text
        self._axes = [(use, _index(use, "--axes", count, labels)) for use in channels.axes]
        self._commands = [(use, _index(use, "--commands", count, labels)) for use in channels.commands]
        self._on: set[str] = set()
        self._state = NEUTRAL
        self._at = -math.inf
        self.dropped = 0
        self.problem = ""

    def add(self, values: Sequence[object], stamp: float, now: float) -> None:
        """Take the newest sample.

        Args:
            values: A value for each channel.
            stamp: When it was taken, in seconds of the monotonic clock. A time that is not finite or in the future
                counts as now.
            now: Seconds of the monotonic clock.
        """
        at = min(stamp, now) if math.isfinite(stamp) else now
        if len(values) != self._count:
            self._drop(f"expected {self._count} channels, got {len(values)}")
        elif now - at > STALE_AFTER:
            self._drop(f"expected samples of the last {STALE_AFTER:g} s, got one of {now - at:.1f} s ago")
        elif self._is_text:
            self._keep(self._worded(values[0]), at)
        else:
            used = {index: values[index] for _, index in (*self._axes, *self._commands)}
            wrong = [(index, value) for index, value in used.items() if not _is_finite(value)]
            if wrong:
                self._drop(f"channel {wrong[0][0]}: expected a finite number, got {shown(str(wrong[0][1]))}")
            else:
                numbers = {index: float(value) for index, value in used.items()}  # type: ignore[arg-type]
                self._keep(self._steered(numbers), at)

    def state(self, now: float) -> InputState:
        """Return the input now: that of the newest sample, or neutral when it is stale."""
        if self.is_stale(now):
            self._on.clear()
            return NEUTRAL
        return self._state

    def is_stale(self, now: float) -> bool:
        """Return whether the newest sample is too old."""
        return now - self._at > STALE_AFTER

    def lost(self) -> None:
        """Count the newest sample as stale: the stream has gone."""
        self._at = -math.inf

    def _drop(self, problem: str) -> None:
        self.dropped += 1
        self.problem = problem

    def _keep(self, state: InputState, at: float) -> None:
        self._at, self.problem = at, ""
        self._state = InputState(state.forward, state.turn, word=state.word, at=at)

    def _steered(self, numbers: dict[int, float]) -> InputState:
        for use, index in self._commands:
            value = numbers[index] * use.factor
            if value >= self._channels.on:
                self._on.add(use.meaning)
            elif value < self._channels.off:
                self._on.discard(use.meaning)
        if self._on:
            signs = [(0.0, 0.0)] if "stop" in self._on else [WORDS[meaning] for meaning in self._on]
            return self._scaled(math.fsum(forward for forward, _ in signs), math.fsum(turn for _, turn in signs))
        deflection = {use.meaning: numbers[index] * use.factor for use, index in self._axes}
        forward, turn = (without_dead_zone(deflection.get(axis, 0.0), self._channels.dead_zone) for axis in AXES)
        return self._scaled(forward, turn)

    def _worded(self, value: object) -> InputState:
        word = SAID.get(str(value).strip().lower())
        if word is None:
            return NEUTRAL
        state = self._scaled(*WORDS[word], word)
        # Nothing with a share of 0. A mind would drive by the word alone, when it comes without forward and turn.
        return state if state.forward or state.turn or not any(WORDS[word]) else NEUTRAL

    def _scaled(self, forward: float, turn: float, word: str | None = None) -> InputState:
        return InputState(forward * self._channels.forward, turn * self._channels.turn, word=word)


def _index(use: ChannelUse, option: str, count: int, labels: Sequence[str]) -> int:
    """Return the number of a channel."""
    if use.is_number:
        if int(use.channel) < count:
            return int(use.channel)
        raise ChannelError(f"{option}: expected a channel in [0, {count - 1}], got {use.meaning}={use.channel}")
    if labels.count(use.channel) > 1:
        raise ChannelError(
            f"{option}: expected a label of one channel, got {shown(use.channel)} of {labels.count(use.channel)}; "
            "give the channel's number"
        )
    if use.channel in labels:
        return labels.index(use.channel)
    known = ", ".join(_some(labels)) or "none"
    raise ChannelError(
        f"{option}: expected a number or a label of the stream ({known}), got {shown(use.channel)}"
        f"{did_you_mean(use.channel, labels)}"
    )


def _some(labels: Iterable[str], most: int = 16) -> list[str]:
    kept = list(labels)
    return [shown(label) for label in kept[:most]] + (["..."] if len(kept) > most else [])


def _is_finite(value: object) -> bool:
    try:
        return math.isfinite(float(value))  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return False


def _finite(text: str) -> float | None:
    return float(text) if _is_finite(text) else None
