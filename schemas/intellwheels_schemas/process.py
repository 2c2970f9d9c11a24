"""Stops a process on signals. All commands use this module, and no other module handles signals.

A process stops on SIGTERM, on SIGINT, and when the other end of an inherited pipe, the lifeline, closes. The lifeline
tells a child that its parent has ended, for whatever reason. No parent can then kill a child that does not stop, so the
child kills itself after a grace time.
"""

from __future__ import annotations

import argparse
import atexit
import contextlib
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from types import FrameType

from intellwheels_schemas.command_parser import open_descriptor
from intellwheels_schemas.version import add_version_option

SLICE = 0.2
"""Longest single wait in the main thread, s. An untimed wait can miss a signal, so long waits are cut into slices."""

PYTHON = (sys.executable, "-P")
"""The start of the command line of a child that is a module of this project, before `-m`. With -P a file such as
`queue.py` in the working directory does not replace a module of Python."""

THREADS_END = 10.0
"""Time to wait at the end for threads that use the network, s. A busy machine may close a session slowly, and a process
that ends while one of its threads is inside Zenoh is aborted."""

GRACE = 3.0
"""Time in which a process must end after its lifeline has closed, s."""

_network_threads: dict[threading.Thread, Callable[[], object] | None] = {}
_network_lock = threading.Lock()


def add_process_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that every command has: its version, and when it stops."""
    add_version_option(parser)
    parser.add_argument(
        "--lifeline",
        type=open_descriptor,
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
    reading, writing = os.pipe()
    os.set_blocking(writing, False)

    def on_signal(_number: int, _frame: FrameType | None) -> None:
        # Setting the event here could wait for a lock of it that the interrupted code holds, and never get it.
        with contextlib.suppress(BlockingIOError):
            os.write(writing, b"s")

    def set_on_signal() -> None:
        os.read(reading, 1)
        stop.set()

    threading.Thread(target=set_on_signal, name="signals", daemon=True).start()
    signal.signal(signal.SIGTERM, on_signal)
    signal.signal(signal.SIGINT, on_signal)
    atexit.register(_ignore_signals)
    if lifeline is not None:
        threading.Thread(target=_watch, args=(lifeline, stop), name="lifeline", daemon=True).start()
    return stop


def start_network_thread(
    name: str, work: Callable[[], object], *, end: Callable[[], object] | None = None
) -> threading.Thread:
    """Start a thread that uses the network, and let Python wait for it when it ends, at most `THREADS_END`.

    A daemon thread alone is not waited for, and aborts the process if it returns from Zenoh while Python ends. A thread
    that is no daemon is waited for without limit.

    Args:
        name: The thread's name.
        work: What the thread does.
        end: Makes the work return, if it does not return by itself. Called when Python ends, before the wait.

    Returns:
        The thread, for who wants to join it earlier.
    """
    thread = threading.Thread(target=work, name=name, daemon=True)
    with _network_lock:
        for ended in [other for other in _network_threads if not other.is_alive()]:
            del _network_threads[ended]
        # Started first: one that cannot start raises, and is not waited for.
        thread.start()
        _network_threads[thread] = end
    return thread


def join_network_threads() -> None:
    """Wait for the threads of `start_network_thread`, at most `THREADS_END` s in all.

    Threads that they start meanwhile are waited for too. An `end` that fails is reported, and the others are still
    called. Python calls this when it ends.
    """
    deadline = time.monotonic() + THREADS_END
    called: set[threading.Thread] = set()
    while True:
        with _network_lock:
            threads = {thread: end for thread, end in _network_threads.items() if thread.is_alive()}
        for thread, end in threads.items():
            if end is not None and thread not in called:
                called.add(thread)
                try:
                    end()
                except Exception:
                    traceback.print_exc()
        if not threads or time.monotonic() >= deadline:
            break
        for thread in threads:
            thread.join(max(0.0, deadline - time.monotonic()))
    for thread in _callback_threads():
        thread.join(max(0.0, deadline - time.monotonic()))


def _callback_threads() -> list[threading.Thread]:
    """Return the threads on which Zenoh calls back, one for each subscriber, that Python does not wait for by itself.

    They are daemons if a daemon declared the subscriber. They end a moment after it is closed, and abort the process if
    Python has ended before.
    """
    return [
        thread
        for thread in threading.enumerate()
        if thread.daemon and getattr(getattr(thread, "_target", None), "__name__", "") == "pyo3-closure"
    ]


atexit.register(join_network_threads)


def _ignore_signals() -> None:
    """Ignore signals while Python ends: it restores their default, which would replace the exit code of the command."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextlib.contextmanager
def printing() -> Iterator[None]:
    """Let a reader of standard output leave early, as `head` does, without an error."""
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        # Python writes what is left when it ends. Nobody reads it any more.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


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
