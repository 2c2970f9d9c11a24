"""The lease under which the simulator itself obeys: taken, renewed, given back. Pure: time is passed in.

phase    what happened                         then
none     time to ask                           ask
asked    ok                                    held, ask again in `RENEW`
asked    refused or nobody, never held         lost, with words
asked    nobody, was held                      ask again in `RETRY`: a router may come back
asked    this lease is over, was held          ask for a new one at once
asked    somebody else's                       lost, with words
"""

from __future__ import annotations

from typing import Final

from intellwheels_schemas.messages import Result, Take

SECONDS: Final = 2.0
"""Seconds a lease is asked for: what a chair whose joystick died stands still before its mind drives again."""
RENEW: Final = 0.6
"""Seconds between renewals: two may be lost."""
RETRY: Final = 0.3
"""Seconds until the next try when nobody answered."""


class LeaseClient:
    """The lease on one agent.

    Attributes:
        lease: What inputs must show; None while there is none.
        lost: Why it cannot be had, in words; empty while it can.
    """

    def __init__(self, agent: str) -> None:
        self.lease: str | None = None
        self.lost = ""
        self._agent = agent
        self._due = 0.0
        self._asked = False
        self._was_held = False

    def ask(self, now: float) -> Take | None:
        """Return what to ask with when it is time, or None. The answer goes to `answered`."""
        if self._asked or self.lost or now < self._due:
            return None
        self._asked = True
        return Take(agent=self._agent, lease=self.lease, seconds=SECONDS)

    @property
    def is_asking(self) -> bool:
        """Whether an answer is still to come."""
        return self._asked

    def answered(self, result: Result | None, now: float) -> bool:
        """Take an answer, None when nobody gave one; return whether the lease is new."""
        self._asked = False
        if result is not None and result.code == "ok" and result.lease is not None:
            new = result.lease != self.lease
            self.lease, self._was_held, self._due = result.lease, True, now + RENEW
            return new
        if result is None and self._was_held:
            self._due = now + RETRY
        elif result is not None and self.lease is not None:
            # It ran out, or ended with a reset: a new one is asked for before it is given up.
            self.lease, self._due = None, now
        else:
            self.lost = "no simulator answers, or not allowed" if result is None else result.text or result.code
        return False

    def back(self) -> Take | None:
        """Return what gives the lease back, or None when there is none."""
        lease, self.lease = self.lease, None
        return None if lease is None else Take(agent=self._agent, lease=lease, seconds=0.0)
