"""Waits until a process says that it is ready, and tells people what it waits for or compiles meanwhile.

A first start compiles kernels, which takes minutes on a loaded machine. The time that a process has therefore counts
from the last thing that it printed. A process that compiles prints how long it has been at it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

from intellwheels_experiments.run.child_processes import SLICE, ChildProcesses, WaitError

TOLD: Final = ("compiling ", "waiting ")
"""The beginnings of lines that say why a start takes long."""


def await_ready(
    children: ChildProcesses,
    child: str,
    limit: float,
    *,
    check: Callable[[], None] = lambda: None,
    say: Callable[[str], None] = lambda _: None,
    doing: Callable[[str], None] = lambda _: None,
    interval: float = SLICE,
) -> Mapping[str, str]:
    """Wait until a process prints `ready`; return the values of that line.

    Args:
        children: All processes.
        child: The process.
        limit: Seconds that it may print nothing.
        check: Called whenever it is not ready yet; raises to give up.
        say: Prints the first of the lines that say what the start waits for.
        doing: Shows each of them.
        interval: Seconds between two checks.

    Raises:
        WaitError: The process ended, or printed nothing for too long.
    """
    watch = StartWatch(children.log_of(child), limit, say, doing)

    def look() -> Mapping[str, str] | None:
        values = children.find_line(child, "ready")
        if values is None:
            check()
            if watch.over(time.monotonic()):
                raise WaitError(f"no line 'ready' of {child}: it printed nothing for {limit:g} s\n{children.report()}")
        return values

    return children.wait(look, f"line 'ready' of {child}", math.inf, unless=child, interval=interval)


def once(say: Callable[[str], None]) -> Callable[[str], None]:
    """Return a function that says each kind of line once, for several processes that start at the same time."""
    said: set[str] = set()

    def say_once(text: str) -> None:
        kind = text.partition(" ")[0]
        if kind not in said:
            said.add(kind)
            say(text)

    return say_once


class StartWatch:
    """Reads the log of a process that starts.

    Args:
        log: The log.
        limit: Seconds that it may not grow.
        say: Called with the first line of each kind in `TOLD`.
        doing: Called with each of these lines.
    """

    def __init__(self, log: Path, limit: float, say: Callable[[str], None], doing: Callable[[str], None]) -> None:
        self._log = log
        self._limit = limit
        self._say = say
        self._doing = doing
        self._read = 0
        self._rest = b""
        self._said: set[str] = set()
        self._grew: float | None = None

    def over(self, now: float) -> bool:
        """Pass on what was printed since the last call; return whether nothing was printed for too long.

        Args:
            now: Seconds of a monotonic clock.
        """
        with self._log.open("rb") as file:
            file.seek(self._read)
            printed = file.read()
        if printed or self._grew is None:
            self._grew = now
        self._read += len(printed)
        *lines, self._rest = (self._rest + printed).split(b"\n")
        for line in lines:
            text = line.decode("utf-8", "replace")
            kind = next((word for word in TOLD if text.startswith(word)), None)
            if kind is None:
                continue
            self._doing(text)
            if kind not in self._said:
                self._said.add(kind)
                self._say(text)
        return now - self._grew > self._limit
