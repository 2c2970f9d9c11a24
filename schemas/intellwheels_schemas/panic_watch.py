"""Notices that Zenoh has panicked, by what it prints on standard error.

A panic ends a thread of Zenoh and leaves the process without a working network (seen with Zenoh 1.10.2: the router that
forwards a put whose key has 80,000 bytes). Nothing else tells. So the process must be replaced.
"""

from __future__ import annotations

import atexit
import os
import re
import select
import threading
from collections.abc import Callable
from typing import Final

_PANIC: Final = re.compile(rb"thread '[^'\n]{0,80}'(?: \(\d+\))? panicked at [^\n]*zenoh[^\n]*")
"""A line that Rust prints. Lines of ours never begin so, and have the text of peers in quotes."""
_LONGEST: Final = 1000
"""Bytes of a line that are looked at."""
_SLICE: Final = 0.2  # s


class PanicWatch:
    """Passes on what is written to standard error, and looks for a panic in it, until the process ends.

    Args:
        on_panic: Called once, on a thread of its own, with the line of the panic.
    """

    def __init__(self, on_panic: Callable[[str], None]) -> None:
        self._on_panic = on_panic
        self._over = threading.Event()
        self._line = b""
        self._seen = False
        self._real = os.dup(2)
        self._reading, writing = os.pipe()
        os.set_blocking(self._reading, False)
        os.dup2(writing, 2)
        os.close(writing)
        self._thread = threading.Thread(target=self._copy, name="panic-watch", daemon=True)
        self._thread.start()
        atexit.register(self.close)

    def close(self) -> None:
        """Let standard error be as before, with all that was written to it."""
        if not self._over.is_set():
            os.dup2(self._real, 2)
            self._over.set()
            if threading.current_thread() is not self._thread:
                self._thread.join(5 * _SLICE)

    def _copy(self) -> None:
        while True:
            # Read before the look at the flag: what was written before `close` is passed on.
            over = self._over.is_set()
            if select.select([self._reading], [], [], 0.0 if over else _SLICE)[0]:
                data = os.read(self._reading, 65_536)
                if not data:
                    return
                self._pass_on(data)
                self._look(data)
            elif over:
                return

    def _pass_on(self, data: bytes) -> None:
        while data:
            try:
                data = data[os.write(self._real, data) :]
            except OSError:
                return  # nobody reads it any more

    def _look(self, data: bytes) -> None:
        *lines, rest = (self._line + data).split(b"\n")
        self._line = rest[:_LONGEST]
        for line in lines:
            found = _PANIC.match(line)
            if found is not None and not self._seen:
                self._seen = True
                self._on_panic(found[0].decode("utf-8", "replace"))
