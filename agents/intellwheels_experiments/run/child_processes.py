"""Child processes: start them, read their lines, wait for them and end them. All code that runs a process uses this.

Each child is a process group of its own, so that the processes that it starts end with it. Each child also inherits the
reading end of a pipe, the lifeline. The pipe closes when this process is gone, for any reason, and a child of this
project then ends by itself.

There is one loop that waits, `ChildProcesses.wait`, and it always has a deadline. When a wait fails, the error says
what was awaited and shows what the processes printed last.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from signal import SIGCONT, SIGKILL, SIGTERM, Signals
from types import TracebackType
from typing import Final, Self, TypeAlias, TypeVar

from intellwheels_schemas.process import PYTHON

DEADLINE: Final = 30.0
"""Seconds of wall time that a wait may take by default; the machine may be busy."""

READY_LIMIT: Final = 180.0
"""Seconds for which a simulator that is not `ready` may print nothing. While it compiles kernels, it prints."""

GRACE: Final = 3.0
"""Seconds that a child has to end after SIGTERM before it is killed."""

SLICE: Final = 0.02
"""Seconds between two checks while no process prints anything."""

LINE_LIMIT: Final = 4096
"""Bytes: a longer line of a child arrives in pieces."""

UNREAD_LIMIT: Final = 10_000
"""Unread lines of a child that are kept; older ones are dropped."""

TAIL_BYTES: Final = 64 * 1024
"""Bytes at the end of a log in which its last lines are looked for."""

REPORT_LINES: Final = 30
"""Lines of each log in a report."""

STEP_LINE: Final = "asked verb=step "
"""How the simulator's log notes each step of a lockstep test. A report leaves these lines out."""

_T = TypeVar("_T")


class WaitError(AssertionError):
    """A process or a condition did not come in time, or a process ended too early. It fails a test."""


@dataclass(frozen=True, slots=True)
class Exited:
    """How a child ended.

    Attributes:
        code: Its exit code; negative: the number of the signal that ended it.
    """

    child: str
    code: int

    @property
    def how(self) -> str:
        """The end in words: `exit 1`, `killed by SIGKILL`."""
        if self.code >= 0:
            return f"exit {self.code}"
        try:
            return f"killed by {Signals(-self.code).name}"
        except ValueError:
            return f"killed by signal {-self.code}"


@dataclass(frozen=True, slots=True)
class _Line:
    child: str
    text: str


_Output: TypeAlias = _Line | Exited


def parse(line: str) -> tuple[str, Mapping[str, str]]:
    """Return the verb and the values of a printed line: `ended tick=812 hash=...`."""
    verb, *words = line.split() or [""]
    return verb, dict(word.split("=", 1) for word in words if "=" in word)


class ChildProcesses:
    """Child processes by name. Leaving the `with` ends those that still run.

    Args:
        logs: The folder of their logs, one file `<name>.log` per child. It is made if it does not exist.
    """

    def __init__(self, logs: Path) -> None:
        logs.mkdir(parents=True, exist_ok=True)
        self.logs = logs
        self._lifeline, self._lifeline_writer = os.pipe()
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._threads: dict[str, threading.Thread] = {}
        self._output: SimpleQueue[_Output] = SimpleQueue()
        self._unread: dict[str, deque[str]] = {}
        self._exits: dict[str, Exited] = {}
        self._dismissed: set[str] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # ------------------------------------------------------------ start

    def start(self, name: str, module: str, *arguments: str) -> str:
        """Start a command of this project, given by its module, with this Python and the lifeline.

        Returns:
            The child's name, as `launch` returns it.
        """
        python = PYTHON if module.startswith("intellwheels_") else PYTHON[:1]
        command = [*python, "-m", module, *arguments]
        return self.launch(name, lambda lifeline: [*command, "--lifeline", str(lifeline)])

    def launch(
        self,
        name: str,
        command: Callable[[int], Sequence[str]],
        environment: Mapping[str, str] | None = None,
        *,
        merge_errors: bool = False,
    ) -> str:
        """Start any program.

        Args:
            name: The child's name.
            command: Makes the command line from the file descriptor of the lifeline, which the child inherits.
            environment: Variables to add to those of this process.
            merge_errors: Whether standard error is read like standard output, in the order of writing. Otherwise it
                goes to the log only.

        Returns:
            The child's name, with a number if the name was used before: `agent`, `agent.2`, `agent.3`.

        Raises:
            OSError: The program cannot be started.
        """
        child, number = name, 1
        while child in self._unread:
            number += 1
            child = f"{name}.{number}"
        path = self.log_of(child)
        path.write_bytes(b"")
        # Opened for appending, because `_read` writes the child's output to the same file.
        with path.open("ab") as log:
            process = subprocess.Popen(
                command(self._lifeline),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT if merge_errors else log,
                # A group of its own: Ctrl-C in a terminal reaches this process only.
                process_group=0,
                pass_fds=(self._lifeline,),
                env={**os.environ, "PYTHONUNBUFFERED": "1", **(environment or {})},
            )
        self._processes[child] = process
        self._unread[child] = deque(maxlen=UNREAD_LIMIT)
        reader = threading.Thread(target=self._read, args=(child, process, path), name=f"{child}-lines", daemon=True)
        waiter = threading.Thread(target=self._await_exit, args=(child, process, reader), name=child, daemon=True)
        self._threads[child] = waiter
        reader.start()
        waiter.start()
        return child

    # ------------------------------------------------------------ look

    @property
    def running(self) -> tuple[str, ...]:
        """The children that run, in the order of their start."""
        return tuple(child for child, process in self._processes.items() if process.poll() is None)

    @property
    def exits(self) -> Mapping[str, Exited]:
        """The children that ended, by name, in the order in which `receive` learned of it. Not those dismissed."""
        return {child: exited for child, exited in self._exits.items() if child not in self._dismissed}

    def exited(self, child: str) -> Exited | None:
        """Return how a child ended, or None if `receive` has not learned of its end."""
        return self._exits.get(child)

    def receive(self, timeout: float = 0.0) -> None:
        """Take in what the children printed and which of them ended.

        Args:
            timeout: Seconds to wait for the first line or end.
        """
        try:
            output = self._output.get(timeout=timeout) if timeout > 0.0 else self._output.get_nowait()
            while True:
                match output:
                    case _Line(child=child, text=text):
                        self._unread[child].append(text)
                    case Exited(child=child):
                        self._exits[child] = output
                output = self._output.get_nowait()
        except Empty:
            return

    def find_line(self, child: str, verb: str, **values: str) -> dict[str, str] | None:
        """Return the values of a child's next unread line with this verb and these values, or None.

        The line and all before it count as read. Without such a line nothing does.
        """
        unread = self._unread[child]
        for position, text in enumerate(unread):
            if not text.startswith(verb):
                continue
            printed, found = parse(text)
            if printed == verb and values.items() <= found.items():
                for _ in range(position + 1):
                    unread.popleft()
                return dict(found)
        return None

    # ------------------------------------------------------------ wait

    def wait(
        self,
        look: Callable[[], _T | None],
        what: str,
        timeout: float = DEADLINE,
        *,
        unless: str | None = None,
        interval: float = SLICE,
    ) -> _T:
        """Call `look` until it returns anything but None, and return that.

        Args:
            look: Called whenever a child printed a line or ended, and at least once per `interval`.
            what: What is awaited, as a noun: the error says `no <what> within 30 s`.
            timeout: Seconds of wall time.
            unless: A child. Its end is an error, unless `look` finds something in what it printed last.
            interval: Seconds between two calls while no child prints anything.

        Raises:
            WaitError: The time is over, or the child `unless` ended.
        """
        deadline = time.monotonic() + timeout
        while True:
            self.receive()
            # Read before the look, as the last lines of a child may be what is looked for.
            exited = None if unless is None else self.exited(unless)
            found = look()
            if found is not None:
                return found
            if exited is not None:
                raise WaitError(f"no {what}: {unless} ended ({exited.how})\n{self.report()}")
            if time.monotonic() > deadline:
                raise WaitError(f"no {what} within {timeout:g} s\n{self.report()}")
            self.receive(interval)

    def line(self, child: str, verb: str, timeout: float = DEADLINE, **values: str) -> dict[str, str]:
        """Wait until a child prints a line with this verb and these values; return all values of the line.

        Raises:
            WaitError: The time is over, or the child ended.
        """
        what = f"line {verb!r} of {child}"
        return self.wait(lambda: self.find_line(child, verb, **values), what, timeout, unless=child)

    def exit(self, child: str, timeout: float = DEADLINE) -> int:
        """Wait until a child ends; return its exit code, or the negative number of the signal that ended it.

        Raises:
            WaitError: It still runs when the time is over.
        """
        return self.wait(lambda: self.exited(child), f"end of {child}", timeout).code

    # ------------------------------------------------------------ end

    def signal(self, child: str, number: Signals) -> None:
        """Send a signal to a child and to what it started.

        Raises:
            ProcessLookupError: It is gone.
        """
        os.killpg(self.pid(child), number)

    def end(self, children: Iterable[str], grace: float = GRACE) -> list[str]:
        """End children: SIGTERM, then SIGKILL to those that still run after `grace` seconds.

        Returns:
            The children that had to be killed.
        """
        ending = list(children)
        for child in ending:
            self._signal_if_running(child, SIGTERM)
            # A stopped process takes its SIGTERM only after it continues.
            self._signal_if_running(child, SIGCONT)
        deadline = time.monotonic() + grace
        killed = []
        for child in ending:
            try:
                self._processes[child].wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                killed.append(child)
                self._signal_if_running(child, SIGKILL)
        for child in ending:
            self._threads[child].join(timeout=2.0)
        return killed

    def dismiss(self, children: Iterable[str], grace: float = GRACE) -> None:
        """End children that others replace. `exits` does not list them, as their end is no fault."""
        ending = list(children)
        self._dismissed.update(ending)
        self.end(ending, grace)

    def close(self, grace: float = GRACE) -> None:
        """End all children that still run, and close the lifeline. A second call does nothing.

        Args:
            grace: Seconds between SIGTERM and SIGKILL.
        """
        self.end(self.running, grace)
        for descriptor in (self._lifeline, self._lifeline_writer):
            with contextlib.suppress(OSError):
                os.close(descriptor)
        self._lifeline = self._lifeline_writer = -1

    # ------------------------------------------------------------ logs

    def pid(self, child: str) -> int:
        """Return a child's process id, which is also the id of its process group."""
        return self._processes[child].pid

    def log_of(self, child: str) -> Path:
        """Return the path of a child's log."""
        return self.logs / f"{child}.log"

    def log(self, child: str) -> str:
        """Return everything that a child printed."""
        return self.log_of(child).read_text(errors="replace")

    def tail(self, child: str, lines: int = 15) -> list[str]:
        """Return the last lines of a child's log, without the simulator's lines about single steps."""
        with contextlib.suppress(OSError), self.log_of(child).open("rb") as log:
            log.seek(max(0, log.seek(0, os.SEEK_END) - TAIL_BYTES))
            printed = log.read().decode("utf-8", "replace").splitlines()
            return [line for line in printed if not line.startswith(STEP_LINE)][-lines:]
        return []

    def sections(self) -> list[tuple[str, str]]:
        """Return for each child a title, its name and state, and the last lines of its log."""
        sections = []
        for child in self._processes:
            exited = self.exited(child)
            title = f"{child} ({exited.how if exited else 'running'})"
            sections.append((title, "\n".join(self.tail(child, REPORT_LINES))))
        return sections

    def report(self) -> str:
        """Return the sections as one text."""
        return "\n".join(f"--- {title}\n{text}" for title, text in self.sections())

    # ------------------------------------------------------------ internals

    def _signal_if_running(self, child: str, number: Signals) -> None:
        if self._processes[child].poll() is None:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self._processes[child].pid, number)

    def _read(self, child: str, process: subprocess.Popen[bytes], path: Path) -> None:
        assert process.stdout is not None  # noqa: S101 - `launch` asked for it
        with process.stdout as lines, path.open("ab", buffering=0) as log:
            while line := lines.readline(LINE_LIMIT):
                log.write(line)
                self._output.put(_Line(child, line.decode("utf-8", "replace").rstrip("\r\n")))

    def _await_exit(self, child: str, process: subprocess.Popen[bytes], reader: threading.Thread) -> None:
        code = process.wait()
        # The processes that the child started must not outlive it.
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, SIGKILL)
        # All lines come before the exit, unless a process outside the group keeps the pipe open.
        reader.join(timeout=1.0)
        self._output.put(Exited(child, code))
