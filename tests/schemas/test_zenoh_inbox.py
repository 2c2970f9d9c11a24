"""The inbox is bounded by arrivals and by bytes, and says what it dropped. `test_link` fills it over real sessions."""

from __future__ import annotations

from dataclasses import dataclass

import zenoh

from intellwheels_schemas.zenoh_inbox import Ask, Inbox, Presence, Put, TooLong


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


def test_a_delete_is_counted_and_not_kept_and_a_token_is_never_dropped() -> None:
    inbox = Inbox(room=0)
    keep(inbox, Sample(Payload(b""), deleted=True), Sample(Payload(b"{}")))
    inbox.on_token(Sample(Payload(b"")))  # type: ignore[arg-type]
    assert (inbox.deleted, inbox.dropped) == (1, 1)
    assert inbox.take() == [Presence("iw/v1/main/in/a/actions", True)]


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


def test_query_is_kept_with_the_key_of_its_queryable() -> None:
    inbox = Inbox()
    query = Query("iw/v1/main/*")
    inbox.on_query(query)  # type: ignore[arg-type]
    inbox.queries_of("iw/v1/main/clock")(query)  # type: ignore[arg-type]
    asks = inbox.take()
    assert [(ask.key, ask.served) for ask in asks if isinstance(ask, Ask)] == [
        ("iw/v1/main/*", ""), ("iw/v1/main/*", "iw/v1/main/clock"),
    ]  # fmt: skip
