"""What a person wants at a moment, whatever they say it with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class Wish:
    """What is wanted now.

    Attributes:
        forward: In [-1, 1].
        turn: In [-1, 1], positive to the left.
        buttons: Numbers of the buttons held, 0 to 63, ascending.
        word: A word said, or None.
    """

    forward: float = 0.0
    turn: float = 0.0
    buttons: tuple[int, ...] = ()
    word: str | None = None

    @property
    def is_nothing(self) -> bool:
        """Whether the hand is off."""
        return self == NOTHING


NOTHING = Wish()


class Source(Protocol):
    """What makes wishes."""

    def wait(self, seconds: float) -> None:
        """Return when something happened, at the latest after so long."""
        ...

    def wish(self, now: float, time: float | None) -> Wish | None:
        """Return what is wanted, or None when there will be no more.

        Args:
            now: Seconds of the wall, from any start.
            time: Simulated seconds of the newest clock, or None before the first.
        """
        ...
