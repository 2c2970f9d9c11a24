"""Closes a session that several threads use.

Zenoh's binding refuses with a `RuntimeError` to close a session while another thread is inside one of its methods, and
refuses every method of a session that is being closed. Which of the two happens depends on the threads' timing.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Iterator
from typing import Any, Final

from intellwheels_schemas.process import THREADS_END

_PAUSE: Final = 0.01  # s
_IN_USE: Final = "borrowed"
"""Word in the text of the binding's `RuntimeError`: "Already borrowed" or "Already mutably borrowed"."""


@contextlib.contextmanager
def closing(session: Any) -> Iterator[Any]:
    """Yield a session, and close it in the end; see `close_session`."""
    try:
        yield session
    finally:
        close_session(session)


def close_session(session: Any) -> None:
    """Close a session as soon as no other thread is inside it. What others start afterwards fails, see `asking`.

    Raises:
        RuntimeError: Another thread was inside the session for `THREADS_END` seconds.
    """
    deadline = time.monotonic() + THREADS_END
    while True:
        try:
            session.close()
        except RuntimeError as error:
            if _IN_USE not in str(error) or time.monotonic() >= deadline:
                raise
            threading.Event().wait(_PAUSE)
        else:
            return


@contextlib.contextmanager
def asking(session: Any) -> Iterator[None]:
    """Call a method of a session that another thread may close.

    Raises:
        ConnectionError: It is closed or being closed.
    """
    try:
        yield
    except Exception as error:  # Zenoh's own class for a session that is closed, `RuntimeError` for one that closes
        if _IN_USE in str(error) or session.is_closed():
            raise ConnectionError("the session is closed") from None
        raise
