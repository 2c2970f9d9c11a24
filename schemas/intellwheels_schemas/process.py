"""The life of a process: what makes it stop. Every command uses this, and nothing else handles signals.

A process stops on SIGTERM, on SIGINT, and when the other end of an inherited pipe closes: that
pipe is how children notice that whoever started them is gone, whatever killed it. Nobody is
left then to insist, so a child that does not stop, stuck in its own code, ends itself.
"""

from __future__ import annotations

import argparse
import os
import signal
import threading
import time
from types import FrameType

SLICE = 0.2
"""Seconds: an untimed wait in the main thread can miss a signal, so waits are cut."""


GRACE = 3.0
"""Seconds a process has to end once its lifeline did."""


def add_process_options(parser: argparse.ArgumentParser) -> None:
    """Give `parser` the options of a command's life."""
    parser.add_argument(
        "--lifeline",
        type=int,
        metavar="FD",
        help="stop when this inherited file descriptor, the reading end of a pipe, reaches its end",
    )


def stop_on_signals(lifeline: int | None = None) -> threading.Event:
    """Return an event that is set when this process must stop.

    To be called from the main thread. Handlers of SIGTERM and SIGINT are replaced.

    Args:
        lifeline: Reading end of a pipe held open by the parent, or None.
    """
    stop = threading.Event()

    def on_signal(_number: int, _frame: FrameType | None) -> None:
        stop.set()

    signal.signal(signal.SIGTERM, on_signal)
    signal.signal(signal.SIGINT, on_signal)
    if lifeline is not None:
        threading.Thread(target=_watch, args=(lifeline, stop), name="lifeline", daemon=True).start()
    return stop


def _watch(lifeline: int, stop: threading.Event) -> None:
    while True:
        try:
            if not os.read(lifeline, 64):
                break
        except OSError:
            break
    stop.set()
    time.sleep(GRACE)
    os.kill(os.getpid(), signal.SIGKILL)
