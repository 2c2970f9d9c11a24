"""The loop of the simulator: it waits, takes what arrived, and lets the service do what is due.

A flood makes no tick late by much work of this loop. Of each key only so many messages are kept for each tick. Until
they are taken they wait where they cost Python nothing, except in lockstep, where each answer wakes the loop.
Messages are taken in pieces, and queries come after them: few at a time between ticks, and those of one key wait only
for their like.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from typing import Final, Protocol

from intellwheels_schemas.process import SLICE
from intellwheels_schemas.zenoh_inbox import Inbox
from intellwheels_server.service import console
from intellwheels_server.service.arrival import Arrival
from intellwheels_server.service.arrival_reader import ArrivalReader
from intellwheels_server.world import State

QUERY_TIME: Final = 0.01
"""Seconds of work for queries between two looks at messages and ticks."""
AT_A_TIME: Final = 2_000
"""Messages, at about 10 µs each, between two looks at queries and ticks. A tick of many agents brings fewer."""
RENEW_EVERY: Final = 0.1
"""Seconds between two renewals of the shares of keys, if no tick comes between. An agent may send 64 messages at once,
400 a second, and 4 more for each tick (`error_replies`), so nothing is dropped that would be read."""
REPORT_EVERY: Final = 1.0
"""Seconds between two reports of what was dropped."""


class Service(Protocol):
    """A live run or the playback of a log, as the main loop uses it."""

    @property
    def exit(self) -> int | None:
        """The exit code of the process once the service is over, else None."""

    @property
    def state(self) -> State:
        """The world."""

    def digest(self) -> str:
        """Return the hash of the state."""

    def begin(self) -> None:
        """Publish what is known before anything happens."""

    def take(self, arrival: Arrival, now: float) -> None:
        """Take what arrived."""

    def work(self, now: float) -> None:
        """Do everything that is due."""

    def due(self, now: float) -> float:
        """Return when to call `work` next if nothing arrives."""

    def spend(self, seconds: float, now: float) -> None:
        """Note that its work has taken so many seconds until now."""

    def finish(self, now: float) -> None:
        """Publish what is left before the service ends."""


def run_service(
    service: Service,
    reader: ArrivalReader,
    inbox: Inbox,
    stop: threading.Event,
    check_claim: Callable[[], None],
    flush_if_due: Callable[[float], None],
    clock: Callable[[], float] = time.monotonic,
) -> None:
    """Wait until something arrives or is due, take what arrived, and do what is due, until the service is over.

    Args:
        service: The service.
        reader: Reads what arrived.
        inbox: What arrived. Its queries are those of `Inbox.queries_of`. Its shares are renewed at each tick.
        stop: Ends the loop.
        check_claim: Called at least once a second.
        flush_if_due: Called after each piece of work, with the time.
        clock: Returns the time, s.
    """
    report = DropReport()
    renewed, tick = clock(), service.state.tick
    while service.exit is None and not stop.is_set():
        now = clock()
        # A long wait in the main thread could delay a signal, so no wait is longer than a slice.
        left = min(service.due(now) - now, SLICE)
        if left > 0.0:
            inbox.wait(left)
            now = clock()
        check_claim()
        if service.state.tick != tick or now - renewed >= RENEW_EVERY:
            renewed, tick = now, service.state.tick
            inbox.renew_shares()
        for delivered in inbox.take(AT_A_TIME):
            arrival = reader.read(delivered)
            if arrival is not None:
                service.take(arrival, now)
        _take_queries(service, reader, inbox, clock)
        service.work(clock())
        done = clock()
        flush_if_due(done)
        service.spend(done - now, done)
        for line in report.lines(inbox.dropped, inbox.unanswered, done, inbox.overflows):
            console.log_line(line)


def _take_queries(service: Service, reader: ArrivalReader, inbox: Inbox, clock: Callable[[], float]) -> None:
    """Take at least one query, and more until a tick is due or the time for queries is over."""
    began = clock()
    while service.exit is None and (ask := inbox.next_query()) is not None:
        arrival = reader.read(ask)
        if arrival is not None:
            service.take(arrival, clock())
        # The last reference ends the query for whoever asked, unless the service keeps it.
        del ask, arrival
        now = clock()
        if now - began > QUERY_TIME or service.due(now) <= now:
            return


class DropReport:
    """Says what was dropped, at most once in `REPORT_EVERY` seconds."""

    def __init__(self) -> None:
        self._arrivals = 0
        self._queries: dict[str, int] = {}
        self._overflows = 0
        self._next = 0.0

    def lines(self, arrivals: int, queries: Mapping[str, int], now: float, overflows: int = 0) -> list[str]:
        """Return the lines of a report, if one is due.

        Args:
            arrivals: Number of messages dropped so far.
            queries: Number of queries dropped so far, by the key of the queryable.
            now: The time, s.
            overflows: How often a ring was found full so far.
        """
        if now < self._next or (arrivals, queries, overflows) == (self._arrivals, self._queries, self._overflows):
            return []
        found = []
        if overflows != self._overflows:
            found.append("dropped arrivals=some why='a ring of messages was full; its oldest may be lost'")
        if arrivals != self._arrivals:
            found.append(f"dropped arrivals={arrivals - self._arrivals} why='more than can be read'")
        for key, count in list(queries.items()):
            if more := count - self._queries.get(key, 0):
                found.append(f"dropped queries={more} key={key} why='more than can be answered'")
        self._arrivals, self._queries, self._overflows = arrivals, dict(queries), overflows
        self._next = now + REPORT_EVERY
        return found
