"""Counters of a controller that wrap around, extended to whole numbers that do not. Pure."""

from __future__ import annotations

from typing import Final

BITS: Final = 32
"""Width of the counters `seq`, `ms`, `left` and `right` of the serial line, as PROTOCOL.md states it."""
MODULUS: Final = 1 << BITS
MAX_UNSIGNED: Final = MODULUS - 1
MIN_SIGNED: Final = -(MODULUS >> 1)
MAX_SIGNED: Final = (MODULUS >> 1) - 1


class WrappingCounter:
    """A counter without wrap-around, made from the values of one that wraps.

    Two successive values must differ by less than half the modulus. Then the shorter way round is the true one:

        difference = (value - last + 2^31) mod 2^32 - 2^31
    """

    def __init__(self) -> None:
        self._total: int | None = None

    def extend(self, value: int) -> int:
        """Return the count at a value of the counter: the value itself at first, then further or back from there."""
        if self._total is None:
            self._total = value
        else:
            self._total += to_signed(value - self._total)
        return self._total

    def is_behind(self, value: int) -> bool:
        """Return whether a value lies before the last one, as after a restart of the controller."""
        return self._total is not None and to_signed(value - self._total) < 0

    def reset(self) -> None:
        """Start again at the next value, because the controller has restarted."""
        self._total = None


def to_signed(count: int) -> int:
    """Return a count as a signed 32-bit counter shows it, in [-2^31, 2^31 - 1]."""
    return (count - MIN_SIGNED) % MODULUS + MIN_SIGNED


def to_unsigned(count: int) -> int:
    """Return a count as an unsigned 32-bit counter shows it, in [0, 2^32 - 1]."""
    return count % MODULUS
