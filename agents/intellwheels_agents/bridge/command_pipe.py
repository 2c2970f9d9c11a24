"""Lines that a stand-in reads while it runs: faults to play, from a named pipe or from standard input."""

from __future__ import annotations

import os
import select
from collections.abc import Callable
from pathlib import Path


class CommandPipe:
    """A source of lines."""

    def __init__(self, path: Path | None, obey: Callable[[str], None], refuse: Callable[[str], None]) -> None:
        """Open it.

        Args:
            path: A named pipe; None for standard input.
            obey: Called with each line; a ValueError refuses it.
            refuse: Called with a line that was refused.
        """
        # Opened for writing too, so that the pipe does not end with its first writer.
        self._source = os.open(path, os.O_RDWR) if path is not None else 0
        self._obey = obey
        self._refuse = refuse
        self._is_open = True
        self._rest = ""

    def poll(self, seconds: float) -> None:
        """Wait for so many seconds at most, and obey the lines that have come."""
        if not select.select([self._source] if self._is_open else [], [], [], seconds)[0]:
            return
        data = os.read(self._source, 4096)
        self._is_open = bool(data)
        *lines, self._rest = (self._rest + data.decode("ascii", "replace")).split("\n")
        for line in lines:
            try:
                self._obey(line)
            except (ValueError, OverflowError):
                self._refuse(line)
