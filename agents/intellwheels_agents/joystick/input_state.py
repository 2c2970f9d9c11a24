"""The present input of a person, from any device."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Final, Protocol

STALE_AFTER: Final = 0.3
"""Seconds after which the newest input of a device no longer counts: the silence that stops a chair everywhere."""


@dataclass(frozen=True, slots=True)
class InputState:
    """The state of an input device.

    Attributes:
        forward: In [-1, 1].
        turn: In [-1, 1], positive to the left.
        buttons: Numbers of the pressed buttons, 0 to 63, ascending.
        word: A spoken word, or None.
        at: When the device gave this, in seconds of the monotonic clock, or None when only its arrival is known. Two
            states that differ only in this are equal.
    """

    forward: float = 0.0
    turn: float = 0.0
    buttons: tuple[int, ...] = ()
    word: str | None = None
    at: float | None = field(default=None, compare=False)

    @property
    def is_neutral(self) -> bool:
        """Whether nothing is pressed, deflected or said."""
        return self == NEUTRAL


NEUTRAL = InputState()


class Source(Protocol):
    """An input device, or a stand-in for one."""

    def wait(self, seconds: float) -> None:
        """Wait at most some seconds; return early when the device has news."""
        ...

    def state(self, now: float, time: float | None) -> InputState | None:
        """Return the state now, or None when the source has ended.

        Args:
            now: Seconds of the monotonic clock.
            time: Simulated seconds of the newest clock message, or None before the first.
        """
        ...


class KeyReader(Protocol):
    """The meaning of held keys, whichever device they come from."""

    @property
    def keys(self) -> Collection[str]:
        """The names of the keys that it uses."""
        ...

    @property
    def help(self) -> tuple[str, ...]:
        """Lines that tell the user the keys."""
        ...

    @property
    def caption(self) -> str:
        """What the user must see at all times, such as a highlighted command; empty for nothing."""
        ...

    def read(self, held: Collection[str], now: float) -> InputState:
        """Return the state of the held keys at a time in seconds of the monotonic clock."""
        ...

    def lost(self) -> None:
        """Stop what drives without a held key: the keys can no longer be seen, so none could stop it."""
        ...
