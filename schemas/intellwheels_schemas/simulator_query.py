"""Asks the simulator of a world, and takes no other peer's word for its own."""

from __future__ import annotations

import threading

import zenoh

from intellwheels_schemas import link
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.repliers import by_simulator


def ask_simulator(
    session: zenoh.Session,
    keys: Keys,
    selector: str,
    data: bytes | None = None,
    *,
    timeout: float = 5.0,
    stop: threading.Event | None = None,
) -> list[link.Answer]:
    """Send a query, and return the replies of the simulator, at least one. Their encoding is JSON if `data` is.

    Args:
        session: Session to use.
        keys: The keys of the world.
        selector: Key of the world, possibly with wildcards and parameters.
        data: Payload of the query in JSON, or None.
        timeout: Seconds to wait.
        stop: Ends the wait.

    Raises:
        NotAllowedError: There was no reply, as this session may not ask that.
        ConnectionError: There was no reply, or several peers replied and none of them has claimed the world.
    """
    answers = link.query(session, selector, data, Encoding.JSON, timeout=timeout, stop=stop)
    found = by_simulator(answers, keys, lambda: link.tokens(session, keys.every_claim))
    if not found:
        raise ConnectionError(f"{selector}: expected the answer of the simulator, got answers of others")
    return found
