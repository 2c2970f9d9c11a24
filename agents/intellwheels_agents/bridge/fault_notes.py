"""What was wrong with what a chair sent: all of it counted, each kind of fault told once."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Final

from intellwheels_schemas.errors import WireError

MAX_KINDS: Final = 20
"""Kinds of fault that are told. A stranger's bytes can make more, which are only counted."""
MAX_TEXT: Final = 300
"""Characters of a text that are told."""


class FaultNotes:
    """Counts faults, and tells each kind once.

    Attributes:
        count: Number of faults.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        """Create it; `tell` receives a sentence for each kind of fault."""
        self.count = 0
        self._tell = tell
        self._kinds: set[str] = set()
        self._lock = threading.Lock()

    def add(self, error: WireError) -> None:
        """Count a message that was dropped. The place in the error is its kind."""
        with self._lock:
            self.count += 1
            if error.where in self._kinds or len(self._kinds) >= MAX_KINDS:
                return
            self._kinds.add(error.where)
        self._tell(error.text[:MAX_TEXT])
