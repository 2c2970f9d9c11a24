from __future__ import annotations

from intellwheels_server.service.error_replies import (
    ERROR_BURST,
    STRANGERS,
    Bucket,
    ErrorLimit,
    MessageLimit,
    flooding,
)


def test_next_reply_counts_the_suppressed_ones() -> None:
    limit = ErrorLimit()
    sent = [limit.admit("one", known=True, now=0.0) for _ in range(30)]
    assert sent[: int(ERROR_BURST)] == [0] * int(ERROR_BURST)
    assert sent[int(ERROR_BURST) :] == [None] * 20
    assert limit.admit("one", known=True, now=1.0) == 20
    assert limit.admit("one", known=True, now=1.0) == 0


def test_mistakes_of_one_agent_do_not_suppress_replies_to_another() -> None:
    limit = ErrorLimit()
    for _ in range(100):
        limit.admit("one", known=True, now=0.0)
    assert limit.admit("two", known=True, now=0.0) == 0


def test_strangers_share_a_limit_and_a_bounded_memory() -> None:
    limit = ErrorLimit()
    sent = [limit.admit(f"a{k}", known=False, now=0.0) for k in range(10 * STRANGERS)]
    assert sum(count is not None for count in sent) <= 20
    assert len(limit._strangers) == STRANGERS


def test_bucket_gives_a_burst_then_its_rate() -> None:
    bucket = Bucket(rate=10.0, burst=3.0, now=0.0)
    assert [bucket.take(0.0) for _ in range(4)] == [True, True, True, False]
    assert [bucket.take(0.1), bucket.take(0.1)] == [True, False]


def test_flood_is_limited_and_fast_lockstep_is_not() -> None:
    limit = MessageLimit()
    assert sum(limit.admit("flood", 7, 0.0) for _ in range(10_000)) == 64
    # 5,000 ticks a second with two messages each: more than the rate, but never more than a tick allows.
    assert all(limit.admit("fast", k // 2, k / 10_000) for k in range(10_000))


def test_flood_is_told_its_limit() -> None:
    assert flooding("actions") == (
        "too-many",
        "actions: expected at most 64 messages in a row, then 400 a second and 4 more for each tick, got another",
        None,
        None,
    )


def test_who_floods_most_is_known_for_a_second_or_two() -> None:
    limit = MessageLimit()
    assert limit.most_refused(0.0) is None
    for number in range(300):
        limit.admit("calm", 0, number / 300)
        limit.admit("flood", 0, 0.5)
        limit.admit("more", 0, 0.5) if number % 2 else None
    assert limit.most_refused(1.0) == "flood"
    assert limit.most_refused(1.6) == "flood"
    assert limit.most_refused(4.0) is None
    for number in range(2 * STRANGERS):
        for _ in range(65):
            limit.admit(f"a{number}", 0, 5.0)
    assert len(limit._refused) == STRANGERS
