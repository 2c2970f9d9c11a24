"""When a process stops. Every command uses this module, and nothing else handles signals.

A process stops on SIGTERM, on SIGINT, and when the other end of an inherited pipe, the lifeline, closes. That pipe
tells a child that its parent is gone, whatever killed the parent. Nobody is left then to kill a child that is stuck in
its own code, so it kills itself after a grace time.
"""

from __future__ import annotations

import argparse
import os
import signal
import threading
import time
from types import FrameType

SLICE = 0.2
"""Seconds of a wait: an untimed wait in the main thread can miss a signal, so long waits are cut into slices."""

GRACE = 3.0
"""Seconds in which a process must end after its lifeline did."""


def add_process_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that control when a command stops."""
    parser.add_argument(
        "--lifeline",
        type=int,
        metavar="FD",
        help="stop when a pipe closes; FD is the inherited file descriptor of its read end",
    )


def stop_on_signals(lifeline: int | None = None) -> threading.Event:
    """Return an event that is set when this process must stop.

    Call it from the main thread. It replaces the handlers of SIGTERM and SIGINT.

    Args:
        lifeline: Read end of a pipe that the parent holds open, or None.
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
