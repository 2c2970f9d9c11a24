"""A process beside the simulator, for work that would delay ticks.

It is forked from the simulator before that opens its session, so it has all modules and kernels already. It forks again
for each piece of work. So work that takes too long can be killed, and the next piece begins in a fresh process.

A thread of the simulator hands work over and takes back what came of it, so the main thread never waits for a pipe.
"""

from __future__ import annotations

import contextlib
import os
import queue
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Callable
from multiprocessing.connection import Connection, Pipe, wait
from typing import Any, Final, Generic, Literal, NamedTuple, NoReturn, TypeVar

_Job = TypeVar("_Job")
_Result = TypeVar("_Result")


JOIN_TIMEOUT: Final = 1.0
"""Seconds to wait for the thread when the simulator ends."""


class Outcome(NamedTuple, Generic[_Result]):
    """What became of a piece of work.

    Attributes:
        code: `done`; `late` if it took too long; `crashed` if its process ended before it was done.
        result: What it returned, if it is done.
    """

    code: Literal["done", "late", "crashed"]
    result: _Result | None = None


class SideProcess(Generic[_Job, _Result]):
    """Does one piece of work at a time in a process of its own.

    Args:
        work: Does the work. It must not use the network. What it takes and returns must be picklable.
    """

    def __init__(self, work: Callable[[_Job], _Result]) -> None:
        self._jobs: queue.SimpleQueue[tuple[_Job, float] | None] = queue.SimpleQueue()
        self._outcomes: queue.SimpleQueue[Outcome[_Result]] = queue.SimpleQueue()
        self._pipe, far_end = Pipe()
        with warnings.catch_warnings():
            # The threads of this process only wait in system calls. They hold no lock that the fork could need.
            warnings.simplefilter("ignore", DeprecationWarning)
            self._pid = os.fork()
        if self._pid == 0:
            self._pipe.close()
            _serve(far_end, work)
        far_end.close()
        with contextlib.suppress(OSError):  # it has done so itself
            os.setpgid(self._pid, self._pid)
        self._thread = threading.Thread(target=self._hand_over, name="side process", daemon=True)
        self._thread.start()

    def begin(self, request: _Job, limit: float) -> None:
        """Begin a piece of work, and end it after so many seconds. No other may be under way."""
        self._jobs.put((request, limit))

    def take(self) -> Outcome[_Result] | None:
        """Return what became of the work, once, or None as long as it is not known."""
        try:
            return self._outcomes.get_nowait()
        except queue.Empty:
            return None

    def close(self) -> None:
        """End the process, and whatever it does."""
        self._jobs.put(None)
        with contextlib.suppress(OSError):
            os.killpg(self._pid, signal.SIGKILL)
        with contextlib.suppress(ChildProcessError):
            os.waitpid(self._pid, 0)
        self._thread.join(JOIN_TIMEOUT)
        self._pipe.close()

    def _hand_over(self) -> None:
        while (job := self._jobs.get()) is not None:
            try:
                self._pipe.send(job)
                outcome: Outcome[_Result] = Outcome(*self._pipe.recv())
            except (EOFError, OSError):
                outcome = Outcome("crashed")
            self._outcomes.put(outcome)


def _serve(pipe: Connection, work: Callable[[Any], Any]) -> NoReturn:
    """Take work from a pipe until its other end closes. This is the side process."""
    code = 1
    try:
        os.setpgid(0, 0)  # the work is in this group, and ends with it
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a key stroke reaches all processes of a terminal
        _let_go_of_terminal()
        while True:
            job, limit = pipe.recv()
            outcome = _outcome_of(pipe, work, job, limit)
            pipe.send(tuple(outcome))
    except (EOFError, OSError):
        code = 0
    finally:
        os._exit(code)


def _let_go_of_terminal() -> None:
    """Leave standard input and output to the simulator, so that they close when it ends."""
    nothing = os.open(os.devnull, os.O_RDWR)
    for number in (0, 1):
        os.dup2(nothing, number)


def _outcome_of(pipe: Connection, work: Callable[[Any], Any], job: object, limit: float) -> Outcome[Any]:
    """Do a piece of work in a fork, and return what became of it."""
    ours, far_end = Pipe(duplex=False)
    child = os.fork()
    if child == 0:
        pipe.close()  # the simulator must see its end when the side process ends
        _do(far_end, work, job)
    far_end.close()
    try:
        ready = wait([ours, pipe], timeout=limit)
        if pipe in ready:  # the simulator has ended
            raise EOFError
        if not ready:
            return Outcome("late")
        try:
            return Outcome("done", ours.recv())
        except EOFError:
            return Outcome("crashed")
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        ours.close()


def _do(pipe: Connection, work: Callable[[Any], Any], job: object) -> NoReturn:
    """Do a piece of work, send its result, and end."""
    code = 1
    try:
        pipe.send(work(job))
        code = 0
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
    finally:
        os._exit(code)
