"""Notices in a corner of one page. A refusal that repeats is shown once."""

from __future__ import annotations

import time
from typing import Final

import viser

REFUSED: Final = 8.0
"""Seconds for which a refusal is shown; the same refusal is not shown again meanwhile."""
TOLD: Final = 5.0
"""Seconds for which any other notice is shown."""


class PageNotices:
    """The notices of a page.

    Args:
        client: The browser.
    """

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._refusal, self._refused_at = ("", ""), -REFUSED

    def refused(self, what: str, why: str) -> None:
        """Show that something was not done, in red.

        Args:
            what: What was not done.
            why: The reason.
        """
        # While a stick is held, the request is repeated every second. The same notice would fill the page.
        if (what, why) == self._refusal and time.monotonic() < self._refused_at + REFUSED:
            return
        self._refusal, self._refused_at = (what, why), time.monotonic()
        self._client.add_notification(what, why, color="red", auto_close_seconds=REFUSED)

    def tell(self, title: str, text: str) -> None:
        """Show a notice."""
        self._client.add_notification(title, text, auto_close_seconds=TOLD)
