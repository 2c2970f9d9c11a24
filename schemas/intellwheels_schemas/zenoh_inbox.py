"""A bounded inbox for samples, queries and tokens from Zenoh.

Zenoh calls back on its own threads. Every callback only puts an object into an `Inbox`, and one other thread takes it
out. Samples of which there are many may wait in rings of Zenoh, where they cost Python nothing until they are taken.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial
from typing import Final, NamedTuple

import zenoh

from intellwheels_schemas.codec import MAX_BYTES, Encoding

QUEUE_ROOM: Final = 2_048
"""Queries of one queryable that wait."""
KEY_SHARE: Final = 128
"""Samples on one known key that are kept between two renewals."""
OTHERS_SHARE: Final = 256
"""Samples on all other keys, together, that are kept between two renewals."""
RING_PATIENCE: Final = 0.01
"""Seconds for which samples wait in a ring, so that `Inbox.wait` returns once for all that came meanwhile."""
LOOKED_AT: Final = 4_096
"""Samples of a ring that one `Inbox.take` looks at, at about 1 µs each: a flood must not delay a tick by much."""
_PUT: Final = zenoh.SampleKind.PUT


class Put(NamedTuple):
    """A sample that arrived."""

    key: str
    data: bytes
    encoding: str


class TooLong(NamedTuple):
    """A sample or query that was too long for the inbox; its bytes were not kept."""

    key: str
    length: int


class Ask(NamedTuple):
    """A query that arrived. The query ends when this object is deleted, so answer it soon.

    Attributes:
        served: Key of the queryable, if its callback noted it.
    """

    key: str
    parameters: str
    data: bytes
    encoding: str
    query: zenoh.Query
    served: str = ""

    def reply(self, data: bytes, encoding: Encoding, key: str | None = None) -> None:
        """Answer with a payload, on the key of the query or on one that it matches. Whoever asked may be gone."""
        with contextlib.suppress(zenoh.ZError):
            self.query.reply(key or self.key, data, encoding=zenoh.Encoding(encoding.value))

    def refuse(self, data: bytes, encoding: Encoding) -> None:
        """Answer with an error reply. Whoever asked may be gone."""
        with contextlib.suppress(zenoh.ZError):
            self.query.reply_err(data, encoding=zenoh.Encoding(encoding.value))

    def matches(self, key: str) -> bool:
        """Return whether the key of the query, which may have wildcards, matches a key."""
        return zenoh.KeyExpr(self.key).intersects(zenoh.KeyExpr(key))

    def close(self) -> None:
        """End the query after the last reply."""
        self.query.drop()  # type: ignore[no-untyped-call]


class Presence(NamedTuple):
    """A liveliness token that appeared or disappeared."""

    key: str
    alive: bool


Arrival = Put | TooLong | Ask | Presence


@dataclass(slots=True, eq=False)
class _Ring:
    """A ring of Zenoh: how to receive from it, how many samples it holds, and how many came since it was last empty."""

    receive: Callable[[], zenoh.Sample | None]
    room: int
    row: int = 0


class Inbox:
    """A bounded queue of arrivals. Zenoh's threads fill it, and one other thread empties it.

    Queries of the callbacks that `queries_of` returns wait apart, in a queue for each key: they take no room from
    samples, and many queries of one key keep none of another waiting for long.

    With `known` keys, a flood of samples takes no room from others: each known key has a share, and all other keys have
    one together. Whatever is beyond a share is dropped, until `renew_shares`.

    Samples may also wait in rings of Zenoh, which `add_ring` names. `take` empties them, and the same shares hold for
    what was in them. Unlike a callback, a sample that goes into a ring takes no time from the other threads of Python.

    Attributes:
        overflows: How often a ring was found full: then it may have dropped its oldest samples.
        dropped: Number of samples and queries dropped because the inbox was full; tokens are never dropped.
        deleted: Number of samples dropped because they were not puts.
        unanswered: Number of queries dropped because the queue of their key was full, by key.
    """

    def __init__(
        self,
        room: int = 16_384,
        max_bytes: int = MAX_BYTES,
        total_bytes: int = 16 * MAX_BYTES,
        known: Collection[str] | None = None,
    ) -> None:
        """Make an empty inbox.

        Args:
            room: Largest number of arrivals that it keeps.
            max_bytes: Longest payload that it keeps.
            total_bytes: Largest total number of bytes that it keeps.
            known: Keys of samples that have a share of their own; they may change meanwhile. None: no shares.
        """
        self.dropped = 0
        self.deleted = 0
        self.overflows = 0
        self.unanswered: dict[str, int] = {}
        self._room = room
        self._max_bytes = max_bytes
        self._total_bytes = total_bytes
        self._bytes = 0
        self._known = known
        self._shares: dict[str, int] = {}  # samples kept of each known key, and of all others ("")
        self._kept: deque[Arrival] = deque()
        self._queues: dict[str, deque[Ask]] = {}
        self._turns: deque[str] = deque()  # the keys whose queues are not empty
        self._queued_bytes = 0
        self._some = threading.Condition()
        self._rings: list[_Ring] = []
        self._has_more = False  # whether the last look left samples in a ring

    def add_ring(self, receive: Callable[[], zenoh.Sample | None], room: int) -> None:
        """Take samples also from a ring.

        Args:
            receive: Returns the next sample of the ring, or None if it is empty. It never waits.
            room: Number of samples that the ring holds.
        """
        self._rings.append(_Ring(receive, room))

    def _keep(self, arrival: Arrival, length: int) -> None:
        with self._some:
            if length and (len(self._kept) >= self._room or self._bytes + length > self._total_bytes):
                self.dropped += 1
                return
            self._bytes += length
            self._kept.append(arrival)
            self._some.notify()

    def on_sample(self, sample: zenoh.Sample) -> None:
        """Keep a sample. This is the callback for `declare_subscriber`."""
        arrival = self._arrival(sample)
        if arrival is not None:
            self._keep(arrival, _length(arrival))

    def _arrival(self, sample: zenoh.Sample) -> Put | TooLong | None:
        """Return what a sample is, or None if it is dropped."""
        key = str(sample.key_expr)
        # Before anything else is read: to drop a flood must cost little.
        if self._known is not None:
            share, most = (key, KEY_SHARE) if key in self._known else ("", OTHERS_SHARE)
            used = self._shares.get(share, 0)
            if used >= most:
                self.dropped += 1
                return None
            self._shares[share] = used + 1
        if sample.kind != _PUT:
            self.deleted += 1
            return None
        data = sample.payload
        if (length := len(data)) > self._max_bytes:
            return TooLong(key, length)
        return Put(key, data.to_bytes(), str(sample.encoding))

    def _receive(self, most: int | None) -> list[Arrival]:
        """Return what is in the rings, or the first so many of each, and no more bytes than may be kept."""
        found: list[Arrival] = []
        size = 0
        self._has_more = False
        for ring in self._rings:
            receive, last = ring.receive, len(found) + (ring.room if most is None else most)
            for _ in range(LOOKED_AT):
                if len(found) >= last or size > self._total_bytes:
                    break
                sample = receive()
                if sample is None:
                    ring.row = 0
                    break
                ring.row += 1
                arrival = self._arrival(sample)
                if arrival is not None:
                    found.append(arrival)
                    size += _length(arrival)
            self._has_more = self._has_more or ring.row > 0
            if ring.row >= ring.room:
                ring.row = 0
                self.overflows += 1
        return found

    def _look(self) -> bool:
        """Keep the first sample of each ring; return whether there was one."""
        found = False
        for ring in self._rings:
            sample = ring.receive()
            if sample is not None:
                ring.row += 1
                self.on_sample(sample)
                found = True
        return found

    def renew_shares(self) -> None:
        """Let each share be used again."""
        self._shares = {}

    def on_query(self, query: zenoh.Query) -> None:
        """Keep a query. This is the callback for `declare_queryable`."""
        self._keep_query(query, "")

    def queries_of(self, key: str) -> Callable[[zenoh.Query], None]:
        """Return the callback for the queryable of a key; `next_query` returns what it kept.

        It notes that key, for queries that match several keys.
        """
        return partial(self._keep_query, served=key)

    def _keep_query(self, query: zenoh.Query, served: str) -> None:
        payload = query.payload
        length = 0 if payload is None else len(payload)
        key = str(query.key_expr)
        if length > self._max_bytes:
            self._keep(TooLong(key, length), 1)
            return
        data = b"" if payload is None else payload.to_bytes()
        encoding = "" if query.encoding is None else str(query.encoding)
        ask = Ask(key, str(query.parameters), data, encoding, query, served)
        if served:
            self._queue(ask, _size(ask))
        else:
            self._keep(ask, _size(ask))

    def _queue(self, ask: Ask, length: int) -> None:
        with self._some:
            queue = self._queues.setdefault(ask.served, deque())
            if len(queue) >= QUEUE_ROOM or self._queued_bytes + length > self._total_bytes:
                self.unanswered[ask.served] = self.unanswered.get(ask.served, 0) + 1
                return
            if not queue:
                self._turns.append(ask.served)
            queue.append(ask)
            self._queued_bytes += length
            self._some.notify()

    def on_token(self, sample: zenoh.Sample) -> None:
        """Keep the appearance or disappearance of a token. This is the callback for a liveliness subscriber."""
        self._keep(Presence(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT), 0)

    def on_token_reply(self, reply: zenoh.Reply) -> None:
        """Keep a token that was found. For a query of liveliness."""
        if reply.ok is not None:
            self._keep(Presence(str(reply.ok.key_expr), alive=True), 0)

    def next_query(self) -> Ask | None:
        """Remove and return a query that waits, or None. The keys take turns; each has its queries in order."""
        with self._some:
            if not self._turns:
                return None
            key = self._turns.popleft()
            ask = self._queues[key].popleft()
            if self._queues[key]:
                self._turns.append(key)
            self._queued_bytes -= _size(ask)
        return ask

    def take(self, most: int | None = None) -> list[Arrival]:
        """Remove and return all arrivals, or the first so many, in order of arrival; not those of `next_query`."""
        with self._some:
            if most is None or len(self._kept) <= most:
                taken = list(self._kept)
                self._kept.clear()
                self._bytes = 0
            else:
                taken = [self._kept.popleft() for _ in range(most)]
                self._bytes -= sum(map(_length, taken))
        return taken + self._receive(most) if self._rings else taken

    def wait(self, seconds: float) -> bool:
        """Wait for an arrival or the time-out; return whether there is an arrival."""
        if not self._rings:
            with self._some:
                return bool(self._kept or self._turns) or self._some.wait(max(seconds, 0.0))
        if self._has_more:
            return True
        ends = time.monotonic() + seconds
        while (left := ends - time.monotonic()) > 0.0:
            with self._some:
                if self._kept or self._turns or self._some.wait(min(left, RING_PATIENCE)):
                    return True
            if self._look():
                return True
        with self._some:
            return bool(self._kept or self._turns)


def _size(some: Ask | Put) -> int:
    """Return the bytes that count for a sample or a query."""
    return len(some.data) + len(some.key) + 1


def _length(arrival: Arrival) -> int:
    """Return the bytes that count for an arrival."""
    if isinstance(arrival, Put | Ask):
        return _size(arrival)
    return 1 if isinstance(arrival, TooLong) else 0
