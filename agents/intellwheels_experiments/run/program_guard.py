"""Runs a program in any language that belongs to a run, and ends it when the run is gone. It needs nothing but Python.

A program of this project watches its lifeline by itself. Any other program has this guard beside it, in its process
group: `python -m intellwheels_experiments.run.program_guard LIFELINE FOLDER WORD ...`. The guard ends as the program
does, with its exit code or by its signal.
"""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from typing import Final

GRACE: Final = 3.0
"""Seconds that a program has to end after its lifeline has closed; as long as the project's own programs have."""

NOT_STARTED: Final = 127
"""Exit code if the program cannot be started, as of a shell."""


def main(words: Sequence[str]) -> int:
    """Run a program to its end and return its exit code. If a signal ended it, end by the same signal."""
    lifeline, folder, *command = words
    early: list[int] = []
    # A signal to the group reaches the program itself, which inherits no handler.
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda number, _frame: early.append(number))
    try:
        program = subprocess.Popen(command, cwd=folder)
    except OSError as error:
        sys.stderr.write(f"{command[0]}: expected a program that can be started, got {error.strerror}\n")
        return NOT_STARTED
    if early:
        program.send_signal(early[0])
    closed = threading.Event()
    threading.Thread(target=_end_with_lifeline, args=(int(lifeline), closed), name="lifeline", daemon=True).start()
    code = program.wait()
    if closed.is_set():
        # Nobody else is left to end what the program started.
        os.killpg(0, signal.SIGKILL)
    if code < 0:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if -code != signal.SIGKILL:
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    return code


def _end_with_lifeline(lifeline: int, closed: threading.Event) -> None:
    try:
        while os.read(lifeline, 64):
            pass
    except OSError:
        pass
    closed.set()
    for number in (signal.SIGTERM, signal.SIGCONT):
        os.killpg(0, number)
    time.sleep(GRACE)
    os.killpg(0, signal.SIGKILL)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
