"""Lines that a person types on standard input, or a script writes to it, while the process does something else."""

from __future__ import annotations

import os
import select
import threading
from collections.abc import Callable
from typing import Final

_SLICE: Final = 0.2
"""Seconds of one wait, so that the thread ends when the process stops."""


def read_lines(descriptor: int, on_line: Callable[[], None], stop: threading.Event) -> None:
    """Call `on_line` for each line until the input ends or `stop` is set.

    The system suspends a background process that reads from its terminal. So lines are read only while the process is
    in the foreground.

    Args:
        descriptor: The input: a terminal, a pipe or a file.
        on_line: Called without the line's text.
        stop: Ends the reading.
    """
    while not stop.is_set():
        if is_background(descriptor):
            stop.wait(_SLICE)
        elif select.select([descriptor], [], [], _SLICE)[0]:
            try:
                data = os.read(descriptor, 4096)
            except OSError:  # the terminal has hung up
                return
            if not data:
                return
            for _ in range(data.count(b"\n")):
                on_line()


def is_background(descriptor: int) -> bool:
    """Return whether a descriptor is a terminal that another process group owns now."""
    try:
        return os.isatty(descriptor) and os.tcgetpgrp(descriptor) != os.getpgrp()
    except OSError:  # a terminal, but not the one that controls this process
        return False
