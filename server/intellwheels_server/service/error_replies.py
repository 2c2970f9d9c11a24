"""What is said back to senders of wrong things, and how often. Pure: time is passed in.

A complaint costs more than the mistake: each agent's are limited, what was kept back is counted in the next, and
senders that never joined share one limit. Nothing here grows with the number of mistakes or of their senders.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import Final, NamedTuple

from intellwheels_schemas.messages import ErrorCode

RATE: Final = 5.0
"""Complaints a second to one agent."""
BURST: Final = 10.0
"""Complaints in a row before the rate counts."""
STRANGERS: Final = 256
"""Senders that have not joined, remembered by name."""
STRANGER_RATE: Final = 20.0
"""Complaints a second to all of them together."""

MESSAGE_BURST: Final = 64.0
"""Messages in a row an agent may send before the rate counts."""
MESSAGE_RATE: Final = 400.0
"""Messages a second of wall time; and in lockstep so many more a tick as `MESSAGES_A_TICK`."""
MESSAGES_A_TICK: Final = 4.0


class Fault(NamedTuple):
    """What was wrong: the fields of an `Error` that do not depend on when it goes out."""

    code: ErrorCode
    text: str
    where: str | None = None
    seq: int | None = None


class Bucket:
    """A token bucket: so many at once, then at a rate."""

    __slots__ = ("_burst", "_last", "_level", "_rate")

    def __init__(self, rate: float, burst: float, now: float) -> None:
        self._rate, self._burst = rate, burst
        self._level, self._last = burst, now

    def add(self, amount: float) -> None:
        """Put so much in, not over the brim."""
        self._level = min(self._burst, self._level + amount)

    def take(self, now: float) -> bool:
        """Take one out and return whether there was one."""
        level = min(self._burst, self._level + (now - self._last) * self._rate)
        self._last = now
        if level < 1.0:
            self._level = level
            return False
        self._level = level - 1.0
        return True


class _Ledger:
    __slots__ = ("bucket", "kept_back")

    def __init__(self, now: float) -> None:
        self.bucket = Bucket(RATE, BURST, now)
        self.kept_back = 0


class ErrorReplies:
    """Decides which complaints go out."""

    def __init__(self) -> None:
        self._known: dict[str, _Ledger] = {}
        self._strangers: OrderedDict[str, _Ledger] = OrderedDict()
        self._all_strangers = Bucket(STRANGER_RATE, STRANGER_RATE, 0.0)

    def admit(self, agent: str, known: bool, now: float) -> int | None:
        """Return how many were kept back since the last if one may go out to this agent now, else None."""
        ledger = self._ledger(agent, known, now)
        if ledger.bucket.take(now) and (known or self._all_strangers.take(now)):
            kept_back, ledger.kept_back = ledger.kept_back, 0
            return kept_back
        ledger.kept_back += 1
        return None

    def forget(self, agent: str) -> None:
        """Forget an agent that left."""
        self._known.pop(agent, None)

    def _ledger(self, agent: str, known: bool, now: float) -> _Ledger:
        if known:
            return self._known.setdefault(agent, _Ledger(now)) if agent not in self._known else self._known[agent]
        ledger = self._strangers.get(agent)
        if ledger is None:
            ledger = self._strangers[agent] = _Ledger(now)
            if len(self._strangers) > STRANGERS:
                self._strangers.popitem(last=False)
        return ledger


class Gate:
    """Bounds how many messages of one sender are read: a flood costs its sender, not the run."""

    def __init__(self) -> None:
        self._buckets: OrderedDict[str, tuple[Bucket, int]] = OrderedDict()

    def admit(self, agent: str, tick: int, now: float) -> bool:
        """Return whether a message of this agent may be read now."""
        entry = self._buckets.get(agent)
        if entry is None:
            bucket, seen = Bucket(MESSAGE_RATE, MESSAGE_BURST, now), tick
            self._buckets[agent] = (bucket, tick)
            if len(self._buckets) > 16 * STRANGERS:
                self._buckets.popitem(last=False)
        else:
            bucket, seen = entry
        if tick != seen:
            bucket.add(MESSAGES_A_TICK * abs(tick - seen))
            self._buckets[agent] = (bucket, tick)
        return bucket.take(now)
