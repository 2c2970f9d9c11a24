"""The present input of a person, from any device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class InputState:
    """The state of an input device.

    Attributes:
        forward: In [-1, 1].
        turn: In [-1, 1], positive to the left.
        buttons: Numbers of the pressed buttons, 0 to 63, ascending.
        word: A spoken word, or None.
    """

    forward: float = 0.0
    turn: float = 0.0
    buttons: tuple[int, ...] = ()
    word: str | None = None

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
