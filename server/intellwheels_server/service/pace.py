"""When the next tick is due in real time, and how fast the run really goes. Pure: time is passed in.

Deadlines are absolute: tick k is due k intervals after the anchor, so lateness does not add up. The anchor moves
only when the speed changes, after a pause, and when the run is too far behind to catch up.
"""

from __future__ import annotations

from collections import deque
from typing import Final, Literal

LATE_SHARE: Final = 0.1
"""A tick counts as late if it begins later than its deadline by this share of its interval."""
BACKLOG: Final = 0.5
"""Seconds of delay above which the lost time is dropped, because a burst of ticks would not help."""
WINDOW: Final = 1.0
"""Seconds over which the real-time factor is measured."""
WATCHED: Final = 20
"""Ticks that a `LateWatch` looks at."""
MANY_LATE: Final = 3
"""Late ticks among them from which on ticks count as late again and again: one may be late by chance."""


class Metronome:
    """Deadlines of ticks at a speed.

    Attributes:
        period: Simulated time of a tick, s.
        speed: Simulated time over wall time.
        late: How many ticks began late.
    """

    def __init__(self, period: float, speed: float) -> None:
        self.period = period
        self.speed = speed
        self.late = 0
        self._anchor = 0.0
        self._count = 0

    def start(self, now: float) -> None:
        """Set the next deadline to one interval from now."""
        self._anchor = now
        self._count = 1

    def change_speed(self, speed: float, now: float) -> None:
        """Continue at another speed from now on."""
        self.speed = speed
        self.start(now)

    @property
    def interval(self) -> float:
        """Wall time of a tick, s."""
        return self.period / self.speed

    def due(self) -> float:
        """Return when the next tick begins."""
        return self._anchor + self._count * self.interval

    def begin_tick(self, now: float) -> bool:
        """Note that the next tick begins now, and count it if it is late; return whether it is."""
        behind = now - self.due()
        self._count += 1
        is_late = behind > LATE_SHARE * self.interval
        self.late += is_late
        if behind > BACKLOG + self.interval:
            self.start(now)
        return is_late


class LateWatch:
    """Tells when ticks begin to be late again and again, and when that is over."""

    def __init__(self) -> None:
        self._late: deque[bool] = deque(maxlen=WATCHED)
        self._is_late = False

    def add(self, is_late: bool) -> Literal["late", "on time"] | None:
        """Note a tick; return what has changed with it, or None."""
        self._late.append(is_late)
        if not self._is_late and is_late and sum(self._late) >= MANY_LATE:
            self._is_late = True
            return "late"
        if self._is_late and len(self._late) == WATCHED and not any(self._late):
            self._is_late = False
            return "on time"
        return None


class RealTimeFactor:
    """Simulated time over wall time, measured over the last second.

    Args:
        period: Simulated time of a tick, s.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._since: float | None = None
        self._ticks = 0
        self._factor = 0.0

    def count_tick(self, now: float) -> None:
        """Note that a tick was made."""
        if self._since is None:
            self._since = now
        self._ticks += 1
        elapsed = now - self._since
        if elapsed >= WINDOW:
            self._factor = self._ticks * self._period / elapsed
            self._since, self._ticks = now, 0

    def value(self, now: float) -> float:
        """Return the factor over the last window, or over the part of the first window that has passed."""
        if self._since is None:
            return 0.0
        elapsed = now - self._since
        if (self._factor == 0.0 or elapsed > 2.0 * WINDOW) and elapsed > 0.0:
            return self._ticks * self._period / elapsed
        return self._factor

    def reset(self) -> None:
        """Forget everything; measuring starts with the next tick."""
        self._since, self._ticks, self._factor = None, 0, 0.0


class BusyShare:
    """The share of wall time that was spent on work, measured over the last second."""

    def __init__(self) -> None:
        self._since: float | None = None
        self._spent = 0.0
        self._share = 0.0

    def spend(self, seconds: float, now: float) -> None:
        """Note that work has taken so many seconds until now."""
        if self._since is None:
            self._since = now - seconds
        self._spent += seconds
        elapsed = now - self._since
        if elapsed >= WINDOW:
            self._share = self._spent / elapsed
            self._since, self._spent = now, 0.0

    def value(self, now: float) -> float:
        """Return the share over the last window, or over the part of the first window that has passed."""
        if self._since is None or now <= self._since:
            return self._share
        if self._share == 0.0 or now - self._since > 2.0 * WINDOW:
            return min(self._spent / (now - self._since), 1.0)
        return self._share
