"""Undo for moves, turns and placed bodies of one page. Pure."""

from __future__ import annotations

import threading
from collections import deque
from typing import Final

from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import Record

DEPTH: Final = 50
"""Changes that can be undone."""


class UndoStack:
    """The requests that undo the changes of a page, newest last. Any thread may use it.

    It is emptied when a new run starts, as its changes belong to the old one.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._run = ""
        self._requests: deque[tuple[Verb, Record]] = deque(maxlen=DEPTH)

    def __bool__(self) -> bool:
        return bool(self._requests)

    def enter(self, run: str) -> None:
        """Note the current run."""
        with self._lock:
            if run != self._run:
                self._run = run
                self._requests.clear()

    def push(self, run: str, verb: Verb, request: Record) -> None:
        """Note how a change is undone.

        Args:
            run: The run in which the change was requested.
            verb: The verb of the request that undoes it.
            request: Its message.
        """
        with self._lock:
            if run == self._run:
                self._requests.append((verb, request))

    def pop(self) -> tuple[Verb, Record] | None:
        """Return the request that undoes the newest change, and forget it; None if there is none."""
        with self._lock:
            return self._requests.pop() if self._requests else None
