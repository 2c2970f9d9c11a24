"""A bounded inbox for samples, queries and tokens from Zenoh.

Zenoh calls back on its own threads. Every callback only puts an object into an `Inbox`, and one other thread takes it
out.
"""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from collections.abc import Callable, Collection
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


class Inbox:
    """A bounded queue of arrivals. Zenoh's threads fill it, and one other thread empties it.

    Queries of the callbacks that `queries_of` returns wait apart, in a queue for each key: they take no room from
    samples, and many queries of one key keep none of another waiting for long.

    With `known` keys, a flood of samples takes no room from others: each known key has a share, and all other keys have
    one together. Whatever is beyond a share is dropped, until `renew_shares`.

    Attributes:
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
        key = str(sample.key_expr)
        # Before anything else is read: to drop a flood must cost little.
        if self._known is not None and not self._has_share(key):
            self.dropped += 1
            return
        if sample.kind != zenoh.SampleKind.PUT:
            self.deleted += 1
            return
        length = len(sample.payload)
        if length > self._max_bytes:
            self._keep(TooLong(key, length), 1)
        else:
            put = Put(key, sample.payload.to_bytes(), str(sample.encoding))
            self._keep(put, _size(put))

    def _has_share(self, key: str) -> bool:
        share, most = (key, KEY_SHARE) if self._known and key in self._known else ("", OTHERS_SHARE)
        used = self._shares.get(share, 0)
        if used >= most:
            return False
        self._shares[share] = used + 1
        return True

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
        return taken

    def wait(self, seconds: float) -> bool:
        """Wait for an arrival or the time-out; return whether there is an arrival."""
        with self._some:
            return bool(self._kept or self._turns) or self._some.wait(max(seconds, 0.0))


def _size(some: Ask | Put) -> int:
    """Return the bytes that count for a sample or a query."""
    return len(some.data) + len(some.key) + 1


def _length(arrival: Arrival) -> int:
    """Return the bytes that count for an arrival."""
    if isinstance(arrival, Put | Ask):
        return _size(arrival)
    return 1 if isinstance(arrival, TooLong) else 0
