"""Child processes: started in groups of their own, heard line by line, ended whatever happens.

Each child inherits the reading end of one pipe, the lifeline. Its other end closes when this
process is gone, by whatever cause, and that ends the children when nobody is left to do it.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Final, Self, TypeAlias

LINE_LIMIT: Final = 4096
"""Bytes: a longer line of a child arrives in pieces."""

TAIL_LIMIT: Final = 64 * 1024
"""Bytes of the end of a log that are looked at for its last lines."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line that a child wrote on its standard output, without its end."""

    child: str
    text: str


@dataclass(frozen=True, slots=True)
class Exited:
    """A child is gone. All its lines came before this, unless a process of its own keeps its output open.

    Attributes:
        code: Its exit code; negative: the signal that ended it.
    """

    child: str
    code: int

    @property
    def how(self) -> str:
        """The end in words: `exit 1`, `killed by SIGKILL`."""
        if self.code >= 0:
            return f"exit {self.code}"
        try:
            return f"killed by {signal.Signals(-self.code).name}"
        except ValueError:
            return f"killed by signal {-self.code}"


News: TypeAlias = Line | Exited


class ChildProcesses:
    """The processes of a run. Leaving the `with` ends those that still run.

    Args:
        logs: A folder for their logs, `<child>.log` each; it is made if it is not there.
    """

    def __init__(self, logs: Path) -> None:
        logs.mkdir(parents=True, exist_ok=True)
        self.logs = logs
        self._lifeline, self._held = os.pipe()
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._news: SimpleQueue[News] = SimpleQueue()
        self._threads: dict[str, threading.Thread] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def start(
        self, child: str, command: Callable[[int], Sequence[str]], environment: Mapping[str, str] | None = None
    ) -> None:
        """Start a child.

        Args:
            child: Its name here and in its log's name.
            command: Makes its command line from the lifeline's file descriptor, which the child inherits.
            environment: Variables it has beside those of this process.

        Raises:
            OSError: The program cannot be started.
        """
        path = self.log_of(child)
        path.write_bytes(b"")
        # Appending, as `_hear` writes the child's output to the same file.
        with path.open("ab") as log:
            process = subprocess.Popen(
                command(self._lifeline),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=log,
                # A group of its own: a terminal's Ctrl-C reaches this process only, and whatever the child starts ends
                # with it.
                process_group=0,
                pass_fds=(self._lifeline,),
                env={**os.environ, "PYTHONUNBUFFERED": "1", **(environment or {})},
            )
        self._processes[child] = process
        hear = threading.Thread(target=self._hear, args=(child, process, path), name=f"{child}-lines", daemon=True)
        await_end = threading.Thread(target=self._await_end, args=(child, process, hear), name=child, daemon=True)
        self._threads[child] = await_end
        hear.start()
        await_end.start()

    def news(self, timeout: float) -> News | None:
        """Return the next line or end of a child, or None after `timeout` seconds."""
        try:
            return self._news.get(timeout=timeout)
        except Empty:
            return None

    @property
    def living(self) -> tuple[str, ...]:
        """The children that run, in the order of their start."""
        return tuple(child for child, process in self._processes.items() if process.poll() is None)

    def pid(self, child: str) -> int:
        """Return a child's process id, which is its group's too."""
        return self._processes[child].pid

    def log_of(self, child: str) -> Path:
        """Return where a child's log is."""
        return self.logs / f"{child}.log"

    def tail(self, child: str, lines: int = 15) -> list[str]:
        """Return the last lines of a child's log."""
        with contextlib.suppress(OSError), self.log_of(child).open("rb") as log:
            log.seek(max(0, log.seek(0, os.SEEK_END) - TAIL_LIMIT))
            return log.read().decode("utf-8", "replace").splitlines()[-lines:]
        return []

    def end(self, children: Sequence[str], grace: float = 3.0) -> list[str]:
        """End children: SIGTERM, and SIGKILL to those that are there after `grace` seconds.

        Returns:
            Those that had to be killed.
        """
        for child in children:
            self._signal(child, signal.SIGTERM)
            # One that is stopped takes its SIGTERM only when it goes on.
            self._signal(child, signal.SIGCONT)
        deadline = time.monotonic() + grace
        killed = []
        for child in children:
            try:
                self._processes[child].wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                killed.append(child)
                self._signal(child, signal.SIGKILL)
        for child in children:
            self._threads[child].join(timeout=2.0)
        return killed

    def close(self) -> None:
        """End whoever still runs and let the lifeline go. More than once does nothing."""
        self.end(self.living)
        for descriptor in (self._lifeline, self._held):
            with contextlib.suppress(OSError):
                os.close(descriptor)
        self._lifeline = self._held = -1

    def _signal(self, child: str, number: signal.Signals) -> None:
        if self._processes[child].poll() is None:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self._processes[child].pid, number)

    def _hear(self, child: str, process: subprocess.Popen[bytes], path: Path) -> None:
        assert process.stdout is not None  # noqa: S101 - it was asked for in `start`
        with process.stdout as lines, path.open("ab", buffering=0) as log:
            while line := lines.readline(LINE_LIMIT):
                log.write(line)
                self._news.put(Line(child, line.decode("utf-8", "replace").rstrip("\r\n")))

    def _await_end(self, child: str, process: subprocess.Popen[bytes], hear: threading.Thread) -> None:
        code = process.wait()
        # What the child itself started must not outlive it.
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        hear.join(timeout=1.0)
        self._news.put(Exited(child, code))
