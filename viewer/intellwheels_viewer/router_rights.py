"""What this viewer may do by the rules of the router, asked anew when they may have changed."""

from __future__ import annotations

import threading
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from intellwheels_schemas.own_rights import own_rights

if TYPE_CHECKING:
    from intellwheels_schemas.messages import Identity


class RouterRights:
    """The rights of the viewer's identity.

    Attributes:
        identity: The identity with what it may do; None if it has none, or if nobody knows.
    """

    def __init__(self) -> None:
        self.identity: Identity | None = None
        self._is_due = True
        self._asks = False

    def doubt(self) -> None:
        """Ask again at the next `refresh`: the router may have other rules now."""
        self._is_due = True

    def refresh(self, session: Any) -> None:
        """Ask the router if that is due, on a thread of its own."""
        if self._is_due and not self._asks:
            self._is_due, self._asks = False, True
            threading.Thread(target=self._ask, args=(session,), name="rights", daemon=True).start()

    def _ask(self, session: Any) -> None:
        with suppress(Exception):  # the session was closed meanwhile
            self.identity = own_rights(session)
        self._asks = False
