"""Reports a mind that decides for long: it may be in an endless loop."""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Callable
from types import TracebackType

from intellwheels_agents.mind_error import place_in

SLOW_DECISION = 3.0
"""Seconds that a mind decides before it is reported."""
WATCH_PERIOD = 0.5
"""Seconds between two looks at a mind that decides."""


class DecisionWatch:
    """Watches the thread that enters it, from a thread of its own. Use it in a `with` statement.

    Args:
        log: Writes a line to the log; called in the other thread, once for each slow decision.
    """

    def __init__(self, log: Callable[[str], None]) -> None:
        self._log = log
        self._since = math.inf
        self._over = threading.Event()

    def __enter__(self) -> DecisionWatch:
        own = threading.get_ident()
        threading.Thread(target=self._watch, args=(own,), name="watch-decisions", daemon=True).start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()

    def begin(self) -> None:
        """Note that minds may decide from now on."""
        self._since = time.monotonic()

    def end(self) -> None:
        """Note that they have decided."""
        self._since = math.inf

    def _watch(self, thread: int) -> None:
        reported = -math.inf
        while not self._over.wait(WATCH_PERIOD):
            since = self._since
            if since != reported and time.monotonic() - since > SLOW_DECISION:
                reported = since
                frame = sys._current_frames().get(thread)
                self._log(f"slow decide={SLOW_DECISION:g}s at={place_in(frame)}")
