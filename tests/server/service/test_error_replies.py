from __future__ import annotations

from intellwheels_server.service.error_replies import BURST, STRANGERS, Bucket, ErrorReplies, Gate


def test_what_was_kept_back_is_counted_in_the_next() -> None:
    complaints = ErrorReplies()
    told = [complaints.admit("one", known=True, now=0.0) for _ in range(30)]
    assert told[: int(BURST)] == [0] * int(BURST)
    assert told[int(BURST) :] == [None] * 20
    assert complaints.admit("one", known=True, now=1.0) == 20
    assert complaints.admit("one", known=True, now=1.0) == 0


def test_one_agents_mistakes_do_not_silence_what_is_said_to_another() -> None:
    complaints = ErrorReplies()
    for _ in range(100):
        complaints.admit("one", known=True, now=0.0)
    assert complaints.admit("two", known=True, now=0.0) == 0


def test_strangers_share_a_limit_and_are_not_remembered_without_end() -> None:
    complaints = ErrorReplies()
    told = [complaints.admit(f"a{k}", known=False, now=0.0) for k in range(10 * STRANGERS)]
    assert sum(count is not None for count in told) <= 20
    assert len(complaints._strangers) == STRANGERS


def test_a_bucket_gives_a_burst_then_its_rate() -> None:
    bucket = Bucket(rate=10.0, burst=3.0, now=0.0)
    assert [bucket.take(0.0) for _ in range(4)] == [True, True, True, False]
    assert [bucket.take(0.1), bucket.take(0.1)] == [True, False]


def test_a_flood_is_cut_and_a_fast_lockstep_is_not() -> None:
    gate = Gate()
    assert sum(gate.admit("flood", 7, 0.0) for _ in range(10_000)) == 64
    # 5,000 ticks a second with two messages each: more than the rate, but never more than a tick allows.
    assert all(gate.admit("fast", k // 2, k / 10_000) for k in range(10_000))
