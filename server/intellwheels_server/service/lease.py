"""Who may steer a body by user input, and whether anybody still does. Pure: time is passed in.

`take` gives a lease; while it runs only inputs that show it count, and the simulator itself obeys them. A lease not
renewed ends. Dead-man: a user who is silent for 0.3 s of wall time steers no more.
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
class _Voice:
    seq: int | None
    at: float
    silent: bool


class Leases:
    """Leases and silences of all bodies."""

    def __init__(self) -> None:
        self._leases: dict[str, _Lease] = {}
        self._voices: dict[str, _Voice] = {}

    # ------------------------------------------------------------ leases

    def holder(self, agent: str) -> str | None:
        """Return the lease that runs on a body, or None."""
        lease = self._leases.get(agent)
        return lease.lease if lease else None

    def grant(self, agent: str, lease: str, seconds: float, now: float) -> None:
        """Let a lease run, or run on, for so long."""
        self._leases[agent] = _Lease(lease, now + seconds)

    def free(self, agent: str) -> None:
        """End the lease of a body, if one runs."""
        self._leases.pop(agent, None)

    def expired(self, now: float) -> tuple[str, ...]:
        """Return the bodies whose lease is over, which it then is."""
        over = tuple(agent for agent, lease in self._leases.items() if lease.until <= now) if self._leases else ()
        for agent in over:
            del self._leases[agent]
        return over

    def due(self) -> float:
        """Return when the next lease ends. Silence matters to steps only."""
        return min((lease.until for lease in self._leases.values()), default=float("inf"))

    # ------------------------------------------------------------ inputs

    def judge(self, agent: str, user: UserInput, now: float) -> Fault | bool:
        """Return whether an input counts, or what is wrong with it; if it counts, it is the user's latest."""
        lease = self.holder(agent)
        if lease is not None and user.lease != lease:
            got = "another" if user.lease else "none"
            return Fault(
                "lease", f"UserInput.Lease: agent '{agent}' is taken; expected its lease, got {got}", "UserInput.Lease"
            )
        if lease is None and user.lease is not None:
            return Fault(
                "lease",
                f"UserInput.Lease: expected a lease that runs on agent '{agent}', got one that does not",
                "UserInput.Lease",
            )
        voice = self._voices.get(agent)
        # After a silence numbers begin anew: a joystick that was started again counts from 0.
        fresh = voice is None or now - voice.at >= SILENCE or user.seq is None or voice.seq is None
        if not fresh and voice is not None and user.seq is not None and user.seq <= (voice.seq or 0):
            return False
        self._voices[agent] = _Voice(user.seq, now, silent=False)
        return True

    def silent(self, now: float) -> tuple[str, ...]:
        """Return the bodies whose user has just become silent."""
        found = []
        for agent, voice in self._voices.items():
            if not voice.silent and now - voice.at >= SILENCE:
                voice.silent = True
                found.append(agent)
        return tuple(found)

    def hear(self, agent: str, now: float) -> None:
        """Take a body's user for heard now, so that who is silent from now on is found silent."""
        self._voices[agent] = _Voice(None, now, silent=False)

    def forget(self, agent: str) -> None:
        """Forget a body that is gone."""
        self._leases.pop(agent, None)
        self._voices.pop(agent, None)
