"""A sip-and-puff switch as keys: each of its four signals is the key that its interface sends. Knows no device.

signal      drives
hard puff   forward
hard sip    back
soft puff   right
soft sip    left

A signal drives while it lasts. With a latch a hard puff drives forward until a hard sip, for at most `hold` seconds
after the last signal, and soft signals bend its way. Without an update for `STALE_AFTER` the latch is off. A hard sip
that ended the latch drives back only when it comes again after `SIP_PAUSE`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Final

from intellwheels_agents.joystick.input_state import STALE_AFTER, InputState

SIGNALS: Final[dict[str, tuple[float, float]]] = {
    "hard-puff": (1.0, 0.0),
    "hard-sip": (-1.0, 0.0),
    "soft-puff": (0.0, -1.0),
    "soft-sip": (0.0, 1.0),
}
"""The signs of forward and turn of each signal."""
DEFAULT_KEYS: Final = {"hard-puff": "up", "hard-sip": "down", "soft-puff": "right", "soft-sip": "left"}

SIP_PAUSE: Final = 0.7
"""Seconds without a hard sip after which the next one drives back. A terminal repeats a held key after 0.25 to 0.66 s,
and shows a pause meanwhile."""


class SipAndPuff:
    """A sip-and-puff switch as a `KeyReader`.

    Args:
        keys: The key of each signal.
        forward: Share of full forward that a hard signal gives, in [0, 1].
        turn: Share of full turn that a soft signal gives, in [0, 1].
        latch: Whether a hard puff drives on after it has ended.
        hold: Longest time in seconds that a latched puff drives without another signal.
    """

    def __init__(self, keys: Mapping[str, str], forward: float, turn: float, *, latch: bool, hold: float) -> None:
        self._signals = {key: signal for signal, key in keys.items()}
        self._shares = forward, turn
        self._latch = latch
        self._hold = hold
        self._until = self._updated = -1.0
        # Until when a hard sip does not drive back, because it ended the latch.
        self._no_back_until = -1.0
        self.help = (", ".join(f"{key} is {signal}" for signal, key in keys.items()), "escape ends")

    @property
    def keys(self) -> Collection[str]:
        """The keys of the signals."""
        return self._signals.keys()

    @property
    def caption(self) -> str:
        """Whether a puff is latched."""
        if not self._latch:
            return ""
        return "latched: hard sip stops" if self._updated < self._until else "hard puff drives on"

    def read(self, held: Collection[str], now: float) -> InputState:
        """Return the state that the held signals give."""
        signals = {signal for key, signal in self._signals.items() if key in held}
        if now - self._updated > STALE_AFTER:
            self._until = now
        self._updated = now
        if self._latch:
            self._keep_latch(signals, now)
        forward = math.fsum(SIGNALS[signal][0] for signal in signals)
        turn = math.fsum(SIGNALS[signal][1] for signal in signals)
        if "hard-sip" in signals and now < self._no_back_until:
            forward = 0.0
        elif now < self._until:
            forward = 1.0
        return InputState(forward * self._shares[0], turn * self._shares[1])

    def lost(self) -> None:
        """Stop a latched puff."""
        self._updated = -math.inf

    def _keep_latch(self, signals: set[str], now: float) -> None:
        is_latched = now < self._until
        if "hard-sip" in signals:
            if is_latched or now < self._no_back_until:
                self._no_back_until = now + SIP_PAUSE
            self._until = now
            return
        if "hard-puff" in signals or (is_latched and signals):
            self._until = now + self._hold
