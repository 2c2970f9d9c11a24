"""The lease under which the simulator itself obeys the joystick. Pure: the time is an argument.

state    event                                  reaction
free     time to ask                            ask
asked    ok                                     held; ask again after `RENEW_PERIOD`
asked    refused or no answer, never held       failed, with the reason
asked    no answer, was held                    ask again after `RETRY_PERIOD`: a router may come back
asked    the lease has ended, was held          ask for a new one at once
asked    another operator has it                failed, with the reason
"""

from __future__ import annotations

from typing import Final

from intellwheels_schemas.messages import Result, Take

LEASE_SECONDS: Final = 2.0
"""Length of a lease: how long a chair whose joystick died stands still before its mind drives again."""
RENEW_PERIOD: Final = 0.6
"""Seconds between renewals: two of them may be lost."""
RETRY_PERIOD: Final = 0.3
"""Seconds until the next attempt after a request without an answer."""


class LeaseClient:
    """The lease on one agent.

    Attributes:
        lease: What inputs must carry; None without a lease.
        failure: Why the lease cannot be had, as a sentence; empty while it can.
    """

    def __init__(self, agent: str) -> None:
        self.lease: str | None = None
        self.failure = ""
        self._agent = agent
        self._due = 0.0
        self._is_asking = False
        self._was_held = False

    def request(self, now: float) -> Take | None:
        """Return the request to send now, or None. Its answer goes to `answered`."""
        if self._is_asking or self.failure or now < self._due:
            return None
        self._is_asking = True
        return Take(agent=self._agent, lease=self.lease, seconds=LEASE_SECONDS)

    @property
    def is_asking(self) -> bool:
        """Whether an answer is outstanding."""
        return self._is_asking

    def answered(self, result: Result | None, now: float) -> bool:
        """Process an answer, or None when there was none; return whether the lease is new."""
        self._is_asking = False
        if result is not None and result.code == "ok" and result.lease is not None:
            is_new = result.lease != self.lease
            self.lease, self._was_held, self._due = result.lease, True, now + RENEW_PERIOD
            return is_new
        if result is None and self._was_held:
            self._due = now + RETRY_PERIOD
        elif result is not None and self.lease is not None:
            # It ran out, or a reset ended it. Ask for a new one before giving up.
            self.lease, self._due = None, now
        else:
            self.failure = "no simulator answers" if result is None else result.text or result.code
        return False

    def release(self) -> Take | None:
        """Return the request that gives the lease back, or None without a lease."""
        lease, self.lease = self.lease, None
        return None if lease is None else Take(agent=self._agent, lease=lease, seconds=0.0)
