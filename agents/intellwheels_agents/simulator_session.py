"""What every peer of the agents does with its session: opening it, keeping arrivals, asking for the map, leaving.

Zenoh calls back on its own threads. A callback stores what arrived and returns.

Arrivals wait in a `SimpleQueue`. It saves 25 µs a tick against a condition and a deque (measured round trip 128 µs
instead of 152 µs, echo of measures on loopback), and in lockstep every tick waits for every agent.
"""

from __future__ import annotations

import queue
import sys
import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

import zenoh

from intellwheels_schemas import link, zenoh_inbox
from intellwheels_schemas.codec import MAX_BYTES, Encoding, decode, encoding_of
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Map
from intellwheels_schemas.repliers import by_simulator
from intellwheels_schemas.session_closing import closing
from intellwheels_schemas.simulator_query import ask_simulator

SLICE = 0.2
"""Longest single wait, s: a wait without a timeout can miss a signal."""
JOIN_TIMEOUT = 12.0
"""Seconds to wait for the reply to a join: a strict lockstep may first wait ten seconds for another agent."""
CONFIRM_TIMEOUT = 2.0
"""Seconds to wait for the simulator to confirm what a message says."""
LEAVE_TIMEOUT = 2.0
"""Seconds to wait for the reply to a leave. Without a reply, the simulator still sees the liveliness token go."""
QUEUE_LIMIT = 1024
"""Arrivals that may wait while the mind computes: a minute at 20 Hz."""
ARRIVAL_LIMIT = MAX_BYTES
"""Largest arrival that is accepted, in bytes: the contract's limit for one message."""

_Answered = TypeVar("_Answered")


def run_in_session(
    where: link.Link, retry_for: float, stop: threading.Event, run: Callable[[zenoh.Session, float], int]
) -> int:
    """Open a session, call `run` with it and the seconds that are left, close it, and return the exit code of `run`.

    The code is 1 if no session can be opened in time, and 0 if `stop` is set before there is one.

    Args:
        where: Which simulator to connect to, and how.
        retry_for: Seconds to look for a simulator before giving up; may be infinite.
        stop: Set when the process must end.
        run: Serves until the process must end.
    """
    started = time.monotonic()
    try:
        session = link.open_session(
            where,
            stop,
            timeout=retry_for if retry_for < 1e9 else None,
            waiting=lambda why: log(f"waiting why={why!r}"),
        )
    except ConnectionError as error:
        log(str(error))
        return 1
    if session is None:
        return 0
    with closing(session):
        return run(session, max(0.0, retry_for - (time.monotonic() - started)))


class Arrivals(queue.SimpleQueue[zenoh.Sample | zenoh_inbox.Presence | _Answered], Generic[_Answered]):
    """What arrived and waits for the main loop: samples, the presence of the simulator, and answers to queries.

    Attributes:
        dropped: Number of samples dropped because they were too long or too many waited.
    """

    def __init__(self) -> None:
        """Begin without any."""
        super().__init__()
        self.dropped = 0

    def store(self, sample: zenoh.Sample) -> None:
        """Keep a sample. This is the callback for `declare_subscriber`."""
        if self.qsize() < QUEUE_LIMIT and len(sample.payload) <= ARRIVAL_LIMIT:
            self.put(sample)
            return
        if self.dropped == 0:
            why = f"{len(sample.payload)} bytes, {self.qsize()} waiting"
            log(f"dropped key={sample.key_expr} why='{why}; expected at most {ARRIVAL_LIMIT} and {QUEUE_LIMIT}'")
        self.dropped += 1

    def notice(self, token: zenoh.Sample) -> None:
        """Keep that the simulator appeared or disappeared. This is the callback for its liveliness token."""
        self.put(zenoh_inbox.Presence(str(token.key_expr), token.kind == zenoh.SampleKind.PUT))

    def report_dropped(self) -> None:
        """Say in the log how many samples were dropped, if any were."""
        if self.dropped:
            log(f"overflowed arrivals={self.dropped}")


def ask(
    session: zenoh.Session, keys: Keys, key: str, payload: bytes, encoding: Encoding, timeout: float
) -> list[link.Answer]:
    """Return the simulator's answers to a query; none if nobody answered in time."""
    try:
        answers = link.query(session, key, payload, encoding, timeout=timeout)
        return by_simulator(answers, keys, lambda: link.tokens(session, keys.every_claim))
    except (ConnectionError, zenoh.ZError):
        return []


def leave(session: zenoh.Session, key: str, payload: bytes, encoding: Encoding) -> None:
    """Ask to leave, and wait for the answer for a short time."""
    try:
        link.query(session, key, payload, encoding, timeout=LEAVE_TIMEOUT)
    except (ConnectionError, zenoh.ZError) as error:
        # At the end of a scene the simulator may be gone already, which is no fault.
        log(f"unanswered request=leave why={f'the simulator may have ended first: {error}'!r}")


def fetch_map(session: zenoh.Session, keys: Keys) -> Map:
    """Return the simulator's map.

    Raises:
        ConnectionError: There is no answer, or it is an error.
        WireError: The answer is no map.
    """
    answer = ask_simulator(session, keys, keys.map, timeout=JOIN_TIMEOUT)[0]
    if not answer.ok:
        raise ConnectionError(f"map: expected the simulator's map, got an error: {answer.data[:200]!r}")
    return decode(Map, answer.data, encoding_of(answer.encoding, answer.data), strict=False)


def log(line: str) -> None:
    """Print a line for people."""
    sys.stderr.write(line + "\n")
    sys.stderr.flush()
