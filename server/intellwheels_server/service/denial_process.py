"""Reports what the router of a lab denies: a process that reads Zenoh's log from the router's standard output.

It is a process of its own. A thread of the router could wait for a lock of Python that another one holds while it waits
for room in the pipe of the log. It has a child, which reads the log, and reads in its place while the child does not:
stopped, or waiting for a terminal that shows nothing (Ctrl-S). Otherwise the router would wait, and all its clients.
"""

from __future__ import annotations

import contextlib
import fcntl
import mmap
import os
import select
import signal
import subprocess
import sys
import termios
from typing import Final

from intellwheels_schemas.process import PYTHON
from intellwheels_server.service.denials import Denials

_ROOM: Final = 1 << 20
"""Bytes of log that may wait: as many as Linux grants to anybody."""
_CHUNK: Final = 1 << 16
"""Bytes of log that are read at once."""
_END: Final = 2.0
"""Seconds for the last lines."""
_STALL: Final = 1.0
"""Seconds without a read, while log waits, after which the reader does not read."""
_READS, _GAPS = 0, 1
"""Bytes that both processes see: counts of reads, and of the starts and ends of gaps in what the reader gets."""


class DenialProcess:
    """Sends all that is written to standard output to a process that reads it, until it is closed.

    Attributes:
        out: What was standard output before.
    """

    def __init__(self) -> None:
        # Zenoh would log without colours.
        os.environ.pop("NO_COLOR", None)
        self.out = os.fdopen(os.dup(1), "w")
        reading, writing = os.pipe()
        with contextlib.suppress(OSError):
            fcntl.fcntl(writing, fcntl.F_SETPIPE_SZ, _ROOM)
        # In a session of its own, as signals are for the router; it ends when the log does.
        self._child = subprocess.Popen(
            [*PYTHON, "-m", __name__], stdin=reading, stdout=subprocess.PIPE, start_new_session=True
        )
        os.dup2(writing, 1)
        os.close(reading)
        os.close(writing)
        self._over = False

    def has_ended(self) -> bool:
        """Return True once, when the process has ended before its time. Nothing is reported any more then."""
        if self._over or self._child.stdout is None or not select.select([self._child.stdout], [], [], 0.0)[0]:
            return False
        self._drop()
        self._kill()
        return True

    def close(self) -> None:
        """Wait a moment for the last lines, and let standard output be as before."""
        if self.out.closed:
            return
        self._drop()
        try:
            self._child.wait(_END)
        except subprocess.TimeoutExpired:
            self._kill()
        if self._child.stdout is not None:
            self._child.stdout.close()
        self.out.flush()
        os.dup2(self.out.fileno(), 1)
        self.out.close()

    def _kill(self) -> None:
        """Kill the process and its child."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._child.pid, signal.SIGKILL)
        self._child.wait()

    def _drop(self) -> None:
        """Let what is still logged go nowhere, so that nobody waits."""
        self._over = True
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.close(nowhere)


def main() -> int:
    """Report until the log ends, which it does with the router. Return the exit code."""
    shared = mmap.mmap(-1, 2)
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGCHLD})
    reader = os.fork()
    if reader == 0:
        # The router sees by the end of this output that nothing is reported any more. It is the other process's.
        os.close(1)
        _report(shared)
        os._exit(0)
    _watch(reader, shared)
    return 0


def _report(shared: mmap.mmap) -> None:
    """Report what the log says until it ends."""
    denials, rest, gaps = Denials(), b"", 0
    while data := os.read(0, _CHUNK):
        shared[_READS] = (shared[_READS] + 1) % 256
        if shared[_GAPS] != gaps:
            gaps = shared[_GAPS]
            denials.skip()
            rest, data = b"", data.partition(b"\n")[2]
            if gaps % 2 == 0:
                _write("some denials were not reported, as their report had been stopped")
        *lines, rest = (rest + data).split(b"\n")
        for line in lines:
            if words := denials.note(line):
                _write(words)


def _watch(reader: int, shared: mmap.mmap) -> None:
    """Return when the log has ended. Read it, and forget it, while the reader does not."""
    # With a description of its own, as the reader must wait for data.
    log = os.open("/dev/fd/0", os.O_RDONLY | os.O_NONBLOCK)
    room = fcntl.fcntl(log, fcntl.F_GETPIPE_SZ)
    while not _has_ended(reader):
        reads = shared[_READS]
        # Returns early when the reader has ended.
        signal.sigtimedwait({signal.SIGCHLD}, _STALL)
        # A page of the pipe may hold one line only, so that it is full with half of its bytes.
        if shared[_READS] != reads or not (_is_over(log) or _waiting(log) >= room // 4):
            continue
        shared[_GAPS] = (shared[_GAPS] + 1) % 256
        while shared[_READS] == reads and not _has_ended(reader):
            if not _forget(log) and shared[_READS] == reads:
                os.kill(reader, signal.SIGKILL)
                return
        shared[_GAPS] = (shared[_GAPS] + 1) % 256
    os.close(1)
    while _forget(log):
        pass


def _forget(log: int) -> bool:
    """Read some of the log, and forget it; return whether it goes on."""
    if not select.select([log], [], [], _STALL)[0]:
        return True
    try:
        return bool(os.read(log, _CHUNK))
    except BlockingIOError:
        return True  # the reader was faster


def _is_over(log: int) -> bool:
    """Return whether the router has ended, though the end of its log may still be there."""
    poll = select.poll()
    poll.register(log, 0)
    return bool(poll.poll(0))


def _waiting(log: int) -> int:
    """Return how many bytes of log wait."""
    found = fcntl.ioctl(log, termios.FIONREAD, bytes(4))
    return int.from_bytes(found, sys.byteorder)


def _has_ended(reader: int) -> bool:
    try:
        return os.waitpid(reader, os.WNOHANG)[0] != 0
    except ChildProcessError:
        return True


def _write(words: str) -> None:
    with contextlib.suppress(OSError):  # nobody reads it any more
        sys.stderr.write(f"iw-router: {words}\n")
        sys.stderr.flush()


if __name__ == "__main__":
    sys.exit(main())
