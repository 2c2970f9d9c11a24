"""The inbox is bounded by arrivals and by bytes, and says what it dropped. `test_link` fills it over real sessions."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import cast

import zenoh

from intellwheels_schemas.zenoh_inbox import (
    KEY_SHARE,
    LOOKED_AT,
    OTHERS_SHARE,
    QUEUE_ROOM,
    Ask,
    Inbox,
    Presence,
    Put,
    TooLong,
)


class Payload(bytes):
    """Bytes with the reading method of Zenoh's payloads."""

    def to_bytes(self) -> bytes:
        return bytes(self)


@dataclass(frozen=True)
class Sample:
    """What the inbox reads of a sample."""

    payload: Payload
    key_expr: str = "iw/v1/main/in/a/actions"
    encoding: str = "application/json"
    deleted: bool = False

    @property
    def kind(self) -> zenoh.SampleKind:
        return zenoh.SampleKind.DELETE if self.deleted else zenoh.SampleKind.PUT


def keep(inbox: Inbox, *samples: Sample) -> None:
    for sample in samples:
        inbox.on_sample(sample)  # type: ignore[arg-type]


def test_samples_come_out_in_order_with_key_bytes_and_encoding() -> None:
    inbox = Inbox()
    keep(inbox, Sample(Payload(b"1")), Sample(Payload(b"2")))
    key, encoding = "iw/v1/main/in/a/actions", "application/json"
    assert inbox.take() == [Put(key, b"1", encoding), Put(key, b"2", encoding)]
    assert inbox.take() == []


def test_a_sample_that_is_too_long_leaves_its_length_only() -> None:
    inbox = Inbox(max_bytes=3)
    keep(inbox, Sample(Payload(b"1234")))
    assert inbox.take() == [TooLong("iw/v1/main/in/a/actions", 4)]


def test_what_does_not_fit_is_counted_and_room_is_there_again_after_taking() -> None:
    inbox = Inbox(total_bytes=100)
    keep(inbox, *[Sample(Payload(b"x" * 30)) for _ in range(3)])
    assert (len(inbox.take()), inbox.dropped) == (1, 2)
    keep(inbox, Sample(Payload(b"x" * 30)))
    assert (len(inbox.take()), inbox.dropped) == (1, 2)


def test_first_arrivals_can_be_taken_alone_and_give_their_room_back() -> None:
    inbox = Inbox(total_bytes=100, max_bytes=30)
    keep(inbox, Sample(Payload(b"1" * 30)), Sample(Payload(b"2" * 31)))
    inbox.on_token(Sample(Payload(b"")))  # type: ignore[arg-type]
    assert [type(one) for one in inbox.take(1)] == [Put]
    keep(inbox, Sample(Payload(b"3" * 30)))
    assert inbox.dropped == 0
    assert [type(one) for one in inbox.take(2)] == [TooLong, Presence]
    assert [type(one) for one in inbox.take(9)] == [Put]
    assert inbox.take(9) == []


def test_a_delete_is_counted_and_not_kept_and_a_token_is_never_dropped() -> None:
    inbox = Inbox(room=0)
    keep(inbox, Sample(Payload(b""), deleted=True), Sample(Payload(b"{}")))
    inbox.on_token(Sample(Payload(b"")))  # type: ignore[arg-type]
    assert (inbox.deleted, inbox.dropped) == (1, 1)
    assert inbox.take() == [Presence("iw/v1/main/in/a/actions", True)]


def test_flood_on_one_key_uses_up_its_own_share_only() -> None:
    known = {"a", "b"}
    inbox = Inbox(known=known)
    for key, count in (("a", KEY_SHARE + 5), ("x", OTHERS_SHARE), ("y", 7), ("b", 1)):
        keep(inbox, *[Sample(Payload(b"{}"), key)] * count)
    found = [put.key for put in inbox.take() if isinstance(put, Put)]
    assert found == ["a"] * KEY_SHARE + ["x"] * OTHERS_SHARE + ["b"]
    assert inbox.dropped == 5 + 7
    keep(inbox, Sample(Payload(b"{}"), "a"))
    assert inbox.take() == [], "taking gives no share back"
    inbox.renew_shares()
    known.add("y")
    keep(inbox, *[Sample(Payload(b"{}"), key) for key in ("a", "x", "y")])
    assert len(inbox.take()) == 3


def test_inbox_without_known_keys_has_no_shares() -> None:
    inbox = Inbox()
    keep(inbox, *[Sample(Payload(b"{}"))] * (KEY_SHARE + OTHERS_SHARE))
    assert len(inbox.take()) == KEY_SHARE + OTHERS_SHARE


class Ring(deque[Sample]):
    """A ring of Zenoh: full, it drops its oldest sample."""

    def try_recv(self) -> zenoh.Sample | None:
        return cast(zenoh.Sample, self.popleft()) if self else None


def with_ring(inbox: Inbox, room: int = 4 * LOOKED_AT) -> Ring:
    ring = Ring(maxlen=room)
    inbox.add_ring(ring.try_recv, room)
    return ring


def test_rings_are_taken_after_what_was_kept_each_in_order_and_only_so_many_of_each() -> None:
    inbox = Inbox(max_bytes=3)
    first, second = with_ring(inbox), with_ring(inbox)
    first.extend(Sample(Payload(data)) for data in (b"1", b"1234", b"3"))
    second.append(Sample(Payload(b"4"), "k"))
    inbox.on_token(Sample(Payload(b"")))  # type: ignore[arg-type]
    assert [type(one) for one in inbox.take(2)] == [Presence, Put, TooLong, Put]
    assert inbox.wait(9.0), "a ring has more"
    assert [one.data for one in inbox.take() if isinstance(one, Put)] == [b"3"]
    assert inbox.take() == []


def test_wait_ends_with_a_sample_in_a_ring_a_query_or_in_time() -> None:
    inbox = Inbox()
    ring = with_ring(inbox)
    assert not inbox.wait(-1.0)
    assert not inbox.wait(0.001)
    ring.extend([Sample(Payload(b"1")), Sample(Payload(b"2"))])
    assert inbox.wait(9.0)
    assert [one.data for one in inbox.take() if isinstance(one, Put)] == [b"1", b"2"]
    ask(inbox, "c", served="c")
    assert inbox.wait(9.0)


def test_shares_hold_for_what_is_in_a_ring_and_a_look_ends() -> None:
    inbox = Inbox(known={"a", "b"})
    ring = with_ring(inbox)
    ring.extend([Sample(Payload(b"{}"), "a")] * (LOOKED_AT + 1) + [Sample(Payload(b"{}"), "b")])
    assert len(inbox.take()) == KEY_SHARE
    assert [one.key for one in inbox.take() if isinstance(one, Put)] == ["b"]
    assert (inbox.dropped, inbox.overflows) == (LOOKED_AT + 1 - KEY_SHARE, 0)


def test_take_ends_with_the_bytes_that_may_be_kept() -> None:
    inbox = Inbox(total_bytes=100)
    with_ring(inbox).extend([Sample(Payload(b"x" * 30))] * 4)
    assert [len(inbox.take()) for _ in range(3)] == [2, 2, 0]


def test_full_ring_is_counted() -> None:
    inbox = Inbox()
    ring = with_ring(inbox, 3)
    ring.extend([Sample(Payload(b"x"))] * 2)
    assert (len(inbox.take()), inbox.overflows) == (2, 0)
    ring.extend([Sample(Payload(b"x"))] * 5)
    assert (len(inbox.take()), inbox.overflows) == (3, 1)
    assert (inbox.take(), inbox.overflows) == ([], 1)


def test_wait_ends_in_time() -> None:
    inbox = Inbox()
    assert not inbox.wait(0.0)
    assert not inbox.wait(-1.0)
    assert not inbox.wait(0.01)
    assert inbox.take() == []


@dataclass(frozen=True)
class Query:
    """What the inbox reads of a query."""

    key_expr: str
    payload: Payload | None = None
    parameters: str = ""
    encoding: str | None = None


def ask(inbox: Inbox, *keys: str, served: str = "") -> None:
    callback = inbox.queries_of(served) if served else inbox.on_query
    for key in keys:
        callback(Query(key))  # type: ignore[arg-type]


def test_query_is_kept_with_the_key_of_its_queryable() -> None:
    inbox = Inbox()
    ask(inbox, "iw/v1/main/*")
    ask(inbox, "iw/v1/main/*", served="iw/v1/main/clock")
    assert inbox.wait(0.0)
    (plain,) = inbox.take()
    assert isinstance(plain, Ask)
    assert (plain.key, plain.served) == ("iw/v1/main/*", "")
    assert inbox.wait(0.0)
    queued = inbox.next_query()
    assert queued is not None
    assert (queued.key, queued.served) == ("iw/v1/main/*", "iw/v1/main/clock")
    assert inbox.next_query() is None
    assert not inbox.wait(0.0)


def test_many_queries_of_one_key_take_neither_room_nor_turns_from_others() -> None:
    inbox = Inbox(room=1)
    ask(inbox, *["m"] * (QUEUE_ROOM + 3), served="m")
    ask(inbox, "c", "c", served="c")
    keep(inbox, Sample(Payload(b"x")))
    assert len(inbox.take()) == 1
    assert (inbox.dropped, inbox.unanswered) == (0, {"m": 3})
    found = [one.key for one in iter(inbox.next_query, None)]
    assert found[:5] == ["m", "c", "m", "c", "m"]
    assert len(found) == QUEUE_ROOM + 2


def test_queued_queries_are_bounded_by_their_bytes_together() -> None:
    inbox = Inbox(max_bytes=50, total_bytes=100)
    for served in ("m", "c"):
        inbox.queries_of(served)(Query("k", Payload(b"x" * 50)))  # type: ignore[arg-type]
    assert inbox.unanswered == {"c": 1}
    assert inbox.next_query() is not None
    inbox.queries_of("c")(Query("k", Payload(b"x" * 50)))  # type: ignore[arg-type]
    assert inbox.unanswered == {"c": 1}
