"""Reports what the router of a lab denies: a process that reads Zenoh's log from the router's standard output.

It is a process of its own. A thread of the router could wait for a lock of Python that another one holds while it waits
for room in the pipe of the log.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import subprocess
import sys
from typing import Final

from intellwheels_schemas.process import PYTHON
from intellwheels_server.service.denials import Denials

_ROOM: Final = 1 << 20
"""Bytes of log that may wait: as many as Linux grants to anybody."""
_END: Final = 2.0
"""Seconds for the last lines."""


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
            [*PYTHON, "-m", __name__], stdin=reading, stdout=subprocess.DEVNULL, start_new_session=True
        )
        os.dup2(writing, 1)
        os.close(reading)
        os.close(writing)
        self._over = False

    def has_ended(self) -> bool:
        """Return True once, when the process has ended before its time. Nothing is reported any more then."""
        if self._over or self._child.poll() is None:
            return False
        self._drop()
        return True

    def close(self) -> None:
        """Wait a moment for the last lines, and let standard output be as before."""
        if self.out.closed:
            return
        self._drop()
        try:
            self._child.wait(_END)
        except subprocess.TimeoutExpired:
            self._child.kill()
            self._child.wait()
        self.out.flush()
        os.dup2(self.out.fileno(), 1)
        self.out.close()

    def _drop(self) -> None:
        """Let what is still logged go nowhere, so that nobody waits."""
        self._over = True
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.close(nowhere)


def main() -> int:
    """Report until the log ends, which it does with the router. Return the exit code."""
    denials = Denials()
    for line in sys.stdin.buffer:
        if words := denials.note(line):
            with contextlib.suppress(OSError):  # nobody reads it any more
                sys.stderr.write(f"iw-router: {words}\n")
                sys.stderr.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
