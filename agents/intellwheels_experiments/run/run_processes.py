"""Processes of a run that somebody waits on: their lines, their ends, their logs.

Every wait has a deadline and is for something that comes: a line, an end, an answer. What fails says what was
waited for and shows what the processes printed.
"""

from __future__ import annotations

import os
import signal
import socket
import sys
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final, TypeVar

from intellwheels_experiments.run.child_processes import ChildProcesses, Exited, Line
from intellwheels_experiments.run.launch_spec import parse

DEADLINE: Final = 30.0
"""Seconds of wall time a wait may take; the machine may be busy."""

SLICE: Final = 0.02
"""Seconds between two looks when no process says anything."""

TAIL: Final = 30
"""Lines of each log in a report."""

STEP_LINE: Final = "asked verb=step "
"""How the simulator notes a step that was asked for: in lockstep the greater part of its log."""

_T = TypeVar("_T")


class AwaitedError(AssertionError):
    """Something that was waited for did not come, or a process ended that should not; a test fails by it."""


def free_port() -> int:
    """Return a port of this machine where nobody listens now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class RunProcesses:
    """Processes by name, each in a group of its own.

    Args:
        logs: The folder of their logs.
    """

    def __init__(self, logs: Path) -> None:
        self.children = ChildProcesses(logs)
        self._lines: dict[str, deque[str]] = {}
        self._exits: dict[str, Exited] = {}

    def close(self, grace: float = 0.0) -> None:
        """End those that still run, at once or after `grace` seconds to end by themselves."""
        self.children.end(self.children.living, grace)
        self.children.close()

    def start(self, child: str, module: str, *words: str) -> str:
        """Start a command of the project, a module, and return the name it has here."""
        command = [sys.executable, "-m", module, *words]
        return self.launch(child, lambda lifeline: [*command, "--lifeline", str(lifeline)])

    def launch(
        self, child: str, command: Callable[[int], Sequence[str]], environment: Mapping[str, str] | None = None
    ) -> str:
        """Start a process and return the name it has here, numbered when it is not the first of that name.

        Args:
            child: Its name.
            command: Makes its command line from the lifeline's file descriptor.
            environment: Variables beside those of this process.

        Raises:
            OSError: The program cannot be started.
        """
        name, number = child, 1
        while name in self._lines:
            number += 1
            name = f"{child}.{number}"
        self.children.start(name, command, environment)
        # What cannot be started is no process, and none that runs.
        self._lines[name] = deque()
        return name

    def hear(self, timeout: float = 0.0) -> None:
        """Take in what the processes said, waiting so many seconds at most for the first of it."""
        news = self.children.news(timeout)
        while news is not None:
            match news:
                case Line(child=child, text=text):
                    self._lines[child].append(text)
                case Exited(child=child):
                    self._exits[child] = news
            news = self.children.news(0.0)

    def ended(self, child: str) -> Exited | None:
        """Return how a process ended, as far as heard, or None."""
        return self._exits.get(child)

    def line(self, child: str, verb: str, timeout: float = DEADLINE, **wanted: str) -> dict[str, str]:
        """Wait for a line of a process that begins with the verb and has these values; return its values.

        Raises:
            AwaitedError: It does not come.
        """
        lines = self._lines[child]

        def found() -> dict[str, str] | None:
            while lines:
                said, values = parse(lines.popleft())
                if said == verb and wanted.items() <= values.items():
                    return dict(values)
            return None

        return self.wait(found, f"line {verb!r} of {child}", timeout, unless=child)

    def exit(self, child: str, timeout: float = DEADLINE) -> int:
        """Wait for the end of a process; return its exit code, negative for a signal.

        Raises:
            AwaitedError: It goes on.
        """
        return self.wait(lambda: self.ended(child), f"end of {child}", timeout).code

    def wait(
        self, look: Callable[[], _T | None], what: str, timeout: float = DEADLINE, *, unless: str | None = None
    ) -> _T:
        """Look until there is something, which is returned.

        Args:
            look: What is looked for; None is nothing.
            what: Its name, when it does not come.
            timeout: Seconds of wall time until it is given up.
            unless: A process whose end means that it will not come.

        Raises:
            AwaitedError: It did not come.
        """
        deadline = time.monotonic() + timeout
        while True:
            self.hear()
            # Its last words may be what is looked for, so there is one look after its end.
            gone = None if unless is None else self.ended(unless)
            found = look()
            if found is not None:
                return found
            if gone is not None:
                raise AwaitedError(f"{what} did not come: {unless}: {gone.how}\n{self.report()}")
            if time.monotonic() > deadline:
                raise AwaitedError(f"{what} did not come in {timeout:g} s\n{self.report()}")
            self.hear(SLICE)

    def signal(self, child: str, number: signal.Signals) -> None:
        """Send a process, and what it started, a signal."""
        os.killpg(self.pid(child), number)

    def pid(self, child: str) -> int:
        """Return a process's id."""
        return self.children.pid(child)

    def log(self, child: str) -> str:
        """Return all that a process printed."""
        return self.children.log_of(child).read_text(errors="replace")

    def tail(self, child: str, lines: int = TAIL) -> str:
        """Return the last lines of a log, less those that only say that a step was asked for."""
        told = [line for line in self.children.tail(child, sys.maxsize) if not line.startswith(STEP_LINE)]
        return "\n".join(told[-lines:])

    def sections(self) -> list[tuple[str, str]]:
        """Return the last lines of each process's log behind its name and how it ended."""
        found = []
        for child in self._lines:
            gone = self.ended(child)
            found.append((f"{child} ({gone.how if gone else 'runs'})", self.tail(child)))
        return found

    def report(self) -> str:
        """Return the last lines of all logs as one text."""
        return "\n".join(f"--- {title}\n{text}" for title, text in self.sections())
