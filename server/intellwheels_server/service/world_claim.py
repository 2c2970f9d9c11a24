"""Which of several simulators serves a world.

Every simulator that finds no other one claims the world with a liveliness token. Two that start at the same moment both
claim it. The claim that began earlier wins, by wall clock; the other simulator ends. A simulator that was suspended
yields to whoever took its place meanwhile.
"""

from __future__ import annotations

from typing import Final

from intellwheels_schemas.keys import Claim

YIELD_AFTER: Final = 1.0
"""Seconds that an earlier claim must last until a simulator yields to it. A simulator that was suspended shows its old
claim again until it notices."""
SUSPENDED: Final = 2.0
"""Seconds between two looks at the clock after which a process was suspended, or as good as."""
DOUBT: Final = 10.0
"""Seconds after a suspension in which a simulator yields to any other claim: its network comes back later than it."""


class WorldClaim:
    """This process's claim, beside those of others. It reads no clock: `now` must go on during a suspension.

    Args:
        own: The claim of this process.
        now: Seconds of a clock that goes on while the machine sleeps.
    """

    def __init__(self, own: Claim, now: float) -> None:
        self._own = own
        self._others: dict[Claim, float] = {}
        self._looked = self._doubt_until = now

    def begin(self, now: float) -> None:
        """Note that `yields` is called from now on. What took long before that was the start, not a suspension."""
        self._looked = now

    def add(self, claim: Claim, now: float) -> None:
        """Take note of a claim that appeared."""
        if claim != self._own:
            self._others.setdefault(claim, now)

    def remove(self, claim: Claim) -> None:
        """Take note of a claim that disappeared."""
        self._others.pop(claim, None)

    @property
    def is_contested(self) -> bool:
        """Whether there is an earlier claim."""
        return any(claim < self._own for claim in self._others)

    def is_in_doubt(self, now: float) -> bool:
        """Return whether this process was suspended a moment ago, so that it must ask who is there."""
        return now < self._doubt_until

    def yields(self, now: float) -> str | None:
        """Return why this simulator must end, or None if it serves on. Call it at least once a second."""
        if now - self._looked > SUSPENDED:
            self._doubt_until = now + DOUBT
        self._looked = now
        if self._others and now < self._doubt_until:
            return "another simulator took over while this one was suspended"
        for claim, seen in self._others.items():
            if claim < self._own and now - seen >= YIELD_AFTER:
                return "another simulator started earlier"
        return None
