"""The claim of this process on its world, and the claims of other simulators."""

from __future__ import annotations

import time
from typing import Any, Final

import zenoh

from intellwheels_schemas import link, zenoh_inbox
from intellwheels_schemas.keys import Claim, Keys
from intellwheels_schemas.process import SLICE
from intellwheels_schemas.repliers import mark_of
from intellwheels_server.service.world_claim import WorldClaim

PRESENCE_TIMEOUT: Final = 1.0
"""Seconds in which another simulator of this world would answer."""


class WorldTakenError(RuntimeError):
    """Another simulator runs this world; the text says where."""


class ClaimWatch:
    """Claims the world for this process, and watches the claims of others.

    Args:
        session: The Zenoh session.
        keys: The keys of this world.

    Raises:
        WorldTakenError: Another simulator claimed it earlier.
    """

    def __init__(self, session: zenoh.Session, keys: Keys) -> None:
        self._session, self._keys = session, keys
        self._inbox = zenoh_inbox.Inbox()
        own = Claim(time.time_ns(), mark_of(str(session.info.zid())))
        self._token: Any = link.declare_token(session, keys.claim(own))
        self._watch = link.watch_tokens(session, keys.every_claim, self._inbox)
        self._claim = WorldClaim(own, boot_time())
        self._asked = 0.0
        for key in link.tokens(session, keys.every_claim, timeout=PRESENCE_TIMEOUT):
            self._take(key, alive=True)
        try:
            self.begin()
            self.check()
            while self._claim.is_contested:
                self._inbox.wait(SLICE)
                self.check()
        except WorldTakenError:
            self.close()
            raise

    def begin(self) -> None:
        """Note that `check` is called from now on, at least once a second."""
        self._claim.begin(boot_time())

    def check(self) -> None:
        """Take what is known of other claims.

        Raises:
            WorldTakenError: This simulator must end.
        """
        now = boot_time()
        for arrival in self._inbox.take():
            if isinstance(arrival, zenoh_inbox.Presence):
                self._take(arrival.key, alive=arrival.alive)
        why = self._claim.yields(now)
        if why is not None:
            raise WorldTakenError(f"world '{self._keys.world}': {why}, so this one ends")
        if self._claim.is_in_doubt(now) and now - self._asked >= SLICE:
            self._asked = now
            link.look_for_tokens(self._session, self._keys.every_claim, self._inbox)

    def close(self) -> None:
        """Give up the claim."""
        self._watch.undeclare()  # type: ignore[no-untyped-call]
        self._token.undeclare()

    def _take(self, key: str, *, alive: bool) -> None:
        claim = self._keys.parse_claim(key)
        if claim is None:
            return
        if alive:
            self._claim.add(claim, boot_time())
        else:
            self._claim.remove(claim)


def boot_time() -> float:
    """Return seconds of a clock that goes on while the machine sleeps."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)
