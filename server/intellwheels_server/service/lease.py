"""Leases: which user may steer a body, and whether the user is still active. Pure: time is passed in.

`take` grants a lease. While it lasts, only inputs that carry it count, and the simulator itself obeys them. A lease
ends unless it is renewed. A dead-man's switch stops the body of a user who sends nothing for 0.3 s of wall time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from intellwheels_schemas.messages import UserInput
from intellwheels_server.service.error_replies import Fault

SILENCE: Final = 0.3
"""Seconds without input after which a user counts as silent."""


@dataclass(slots=True)
class _Lease:
    lease: str
    until: float


@dataclass(slots=True)
class _LastInput:
    seq: int | None
    at: float
    silent: bool


class Leases:
    """The leases of all bodies, and when the user of each was last heard."""

    def __init__(self) -> None:
        self._leases: dict[str, _Lease] = {}
        self._inputs: dict[str, _LastInput] = {}

    # ------------------------------------------------------------ leases

    def active(self, agent: str) -> str | None:
        """Return the lease on a body, or None."""
        lease = self._leases.get(agent)
        return lease.lease if lease else None

    def grant(self, agent: str, lease: str, seconds: float, now: float) -> None:
        """Grant or renew a lease for some seconds."""
        self._leases[agent] = _Lease(lease, now + seconds)

    def release(self, agent: str) -> None:
        """End the lease on a body, if there is one."""
        self._leases.pop(agent, None)

    def take_expired(self, now: float) -> tuple[str, ...]:
        """Remove the leases that have run out and return their bodies."""
        expired = tuple(agent for agent, lease in self._leases.items() if lease.until <= now) if self._leases else ()
        for agent in expired:
            del self._leases[agent]
        return expired

    def due(self) -> float:
        """Return when the next lease runs out. Silent users do not matter here: each step checks for them."""
        return min((lease.until for lease in self._leases.values()), default=float("inf"))

    # ------------------------------------------------------------ inputs

    def check_input(self, agent: str, user: UserInput, now: float) -> Fault | bool:
        """Return whether an input counts, or what is wrong with it. An input that counts becomes the user's newest."""
        lease = self.active(agent)
        if lease is not None and user.lease != lease:
            got = "another" if user.lease else "none"
            return Fault(
                "lease",
                f"UserInput.Lease: agent '{agent}' is taken; expected the lease of its holder, got {got}",
                "UserInput.Lease",
            )
        if lease is None and user.lease is not None:
            return Fault(
                "lease",
                f"UserInput.Lease: expected a current lease on agent '{agent}', got one that has ended",
                "UserInput.Lease",
            )
        last = self._inputs.get(agent)
        # A joystick that was started again counts from 0: after a silence any number is accepted.
        fresh = last is None or now - last.at >= SILENCE or user.seq is None or last.seq is None
        if not fresh and last is not None and user.seq is not None and user.seq <= (last.seq or 0):
            return False
        self._inputs[agent] = _LastInput(user.seq, now, silent=False)
        return True

    def newly_silent(self, now: float) -> tuple[str, ...]:
        """Return the bodies whose user has become silent since the last call."""
        found = []
        for agent, last in self._inputs.items():
            if not last.silent and now - last.at >= SILENCE:
                last.silent = True
                found.append(agent)
        return tuple(found)

    def expect_input(self, agent: str, now: float) -> None:
        """Treat the user of a body as heard now, so that `newly_silent` reports it unless input comes."""
        self._inputs[agent] = _LastInput(None, now, silent=False)

    def forget(self, agent: str) -> None:
        """Forget a body that is gone."""
        self._leases.pop(agent, None)
        self._inputs.pop(agent, None)
