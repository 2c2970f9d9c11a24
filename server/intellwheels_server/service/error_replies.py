"""How many messages of a sender are read, and how many error replies it gets. Pure: time is passed in.

An error reply costs more than the mistake, so each agent gets a limited number of them. The next reply says how many
were suppressed. Senders that never joined share one limit. Memory does not grow with the number of mistakes or
senders.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import Final, NamedTuple

from intellwheels_schemas.messages import ErrorCode

ERROR_RATE: Final = 5.0
"""Error replies a second to one agent."""
ERROR_BURST: Final = 10.0
"""Error replies in a row before the rate limit applies."""
UNASKED_RATE: Final = 0.2
"""Reports a second about user input that an agent did not ask for, and about keys that nobody reads."""
UNASKED_BURST: Final = 2.0
"""Such reports in a row before the rate applies."""
STRANGERS: Final = 256
"""Senders that have not joined whose names are remembered."""
STRANGER_RATE: Final = 20.0
"""Error replies a second to all senders that have not joined, together."""

MESSAGE_BURST: Final = 64.0
"""Messages in a row that an agent may send before the rate limit applies."""
MESSAGE_RATE: Final = 400.0
"""Messages a second of wall time that an agent may send."""
MESSAGES_PER_TICK: Final = 4.0
"""Messages that an agent may send in addition with each tick, as lockstep may run faster than the rate."""


class Fault(NamedTuple):
    """The fault of a message: the fields of an `Error` that do not depend on the time at which it is sent."""

    code: ErrorCode
    text: str
    where: str | None = None
    seq: int | None = None


def flooding(kind: str) -> Fault:
    """Return the fault of a message beyond `MessageLimit`; `kind` is the kind of the message, for people."""
    limit = f"at most {MESSAGE_BURST:g} messages in a row, then {MESSAGE_RATE:g} a second"
    return Fault("too-many", f"{kind}: expected {limit} and {MESSAGES_PER_TICK:g} more for each tick, got another")


DELETED: Final = Fault("deleted", "an operator deleted the body of this agent; to join again, start its program again")
"""What an agent is told when its body was deleted, and when it goes on sending."""


class Bucket:
    """A token bucket.

    Args:
        rate: Tokens added a second.
        burst: The largest number of tokens, and the first one.
        now: The current time, s.
    """

    __slots__ = ("_burst", "_last", "_level", "_rate")

    def __init__(self, rate: float, burst: float, now: float) -> None:
        self._rate, self._burst = rate, burst
        self._level, self._last = burst, now

    def add(self, amount: float) -> None:
        """Add tokens, up to the burst."""
        self._level = min(self._burst, self._level + amount)

    def take(self, now: float) -> bool:
        """Take a token and return whether there was one."""
        level = min(self._burst, self._level + (now - self._last) * self._rate)
        self._last = now
        if level < 1.0:
            self._level = level
            return False
        self._level = level - 1.0
        return True


class _Account:
    __slots__ = ("bucket", "suppressed")

    def __init__(self, bucket: Bucket) -> None:
        self.bucket = bucket
        self.suppressed = 0


class ErrorLimit:
    """Decides which error replies are sent.

    Args:
        rate: Error replies a second to one agent.
        burst: Error replies in a row before the rate applies.
    """

    def __init__(self, rate: float = ERROR_RATE, burst: float = ERROR_BURST) -> None:
        self._rate, self._burst = rate, burst
        self._known: dict[str, _Account] = {}
        self._strangers: OrderedDict[str, _Account] = OrderedDict()
        self._all_strangers = Bucket(STRANGER_RATE, STRANGER_RATE, 0.0)

    def admit(self, agent: str, known: bool, now: float) -> int | None:
        """Return how many replies were suppressed since the last one if another may be sent now, else None.

        Args:
            agent: The sender of the faulty message.
            known: Whether it has joined.
            now: The current time, s.
        """
        account = self._account(agent, known, now)
        if account.bucket.take(now) and (known or self._all_strangers.take(now)):
            suppressed, account.suppressed = account.suppressed, 0
            return suppressed
        account.suppressed += 1
        return None

    def forget(self, agent: str) -> None:
        """Forget an agent that left."""
        self._known.pop(agent, None)

    def _account(self, agent: str, known: bool, now: float) -> _Account:
        if known:
            return self._known[agent] if agent in self._known else self._known.setdefault(agent, self._new(now))
        account = self._strangers.get(agent)
        if account is None:
            account = self._strangers[agent] = self._new(now)
            if len(self._strangers) > STRANGERS:
                self._strangers.popitem(last=False)
        return account

    def _new(self, now: float) -> _Account:
        return _Account(Bucket(self._rate, self._burst, now))


class MessageLimit:
    """Limits how many messages of a sender are read, so that a flood costs its sender and not the run."""

    def __init__(self) -> None:
        self._buckets: OrderedDict[str, tuple[Bucket, int]] = OrderedDict()
        self._refused: dict[str, int] = {}  # how many messages of each sender, in this second
        self._since = float("-inf")
        self._most: str | None = None  # the sender of most of them in the second before

    def admit(self, sender: str, tick: int, now: float) -> bool:
        """Return whether a message of this sender may be read now."""
        entry = self._buckets.get(sender)
        if entry is None:
            bucket, seen = Bucket(MESSAGE_RATE, MESSAGE_BURST, now), tick
            self._buckets[sender] = (bucket, tick)
            if len(self._buckets) > 16 * STRANGERS:
                self._buckets.popitem(last=False)
        else:
            bucket, seen = entry
        if tick != seen:
            bucket.add(MESSAGES_PER_TICK * abs(tick - seen))
            self._buckets[sender] = (bucket, tick)
        if bucket.take(now):
            return True
        self._renew(now)
        if sender in self._refused or len(self._refused) < STRANGERS:
            self._refused[sender] = self._refused.get(sender, 0) + 1
        return False

    def most_refused(self, now: float) -> str | None:
        """Return the sender of whose messages most were refused in the last second or two, or None."""
        self._renew(now)
        return max(self._refused, key=self._refused.__getitem__, default=self._most)

    def _renew(self, now: float) -> None:
        passed = now - self._since
        if passed >= 1.0:
            self._most = max(self._refused, key=self._refused.__getitem__, default=None) if passed < 2.0 else None
            self._refused, self._since = {}, now
