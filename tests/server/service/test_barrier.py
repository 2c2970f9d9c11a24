from __future__ import annotations

import pytest

from intellwheels_schemas.file_records import Verdict
from intellwheels_server.service.barrier import FIRST_REPEAT, Answer, Barrier

ONE: Answer = ("one", "actions")
TWO: Answer = ("two", "actions")


def elastic() -> Barrier:
    barrier = Barrier(strict=False, deadline=1.0)
    barrier.open([ONE, TWO], 0.0)
    return barrier


def test_barrier_is_complete_when_every_member_has_answered() -> None:
    barrier = elastic()
    assert barrier.answer("one", "actions", b"a") == "first"
    assert not barrier.complete(0.1)
    assert barrier.awaited == ("two",)
    assert barrier.answer("two", "actions", b"b") == "first"
    assert barrier.complete(0.1)


def test_first_answer_counts_and_the_same_bytes_are_a_duplicate() -> None:
    barrier = elastic()
    barrier.answer("one", "actions", b"a")
    assert barrier.answer("one", "actions", b"a") == "duplicate"
    assert barrier.answer("one", "actions", b"b") == "conflict"


def test_repeated_answer_to_the_last_tick_is_recognised_by_its_bytes() -> None:
    barrier = elastic()
    barrier.answer("one", "actions", b"a")
    barrier.open([ONE, TWO], 0.1)
    assert barrier.repeats_late("one", "actions", b"a")
    assert not barrier.repeats_late("one", "actions", b"b")
    assert not barrier.repeats("one", "actions", b"a")
    assert not barrier.complete(0.1)
    barrier.answer("one", "actions", b"a")
    assert barrier.repeats("one", "actions", b"a")


def test_unanswered_measures_are_repeated_after_20_ms_then_twice_as_long() -> None:
    barrier = elastic()
    barrier.answer("one", "actions", b"a")
    assert barrier.due() == pytest.approx(FIRST_REPEAT)
    assert barrier.to_repeat(0.019) == ()
    assert barrier.to_repeat(0.02) == ("two",)
    assert barrier.to_repeat(0.059) == ()
    assert barrier.to_repeat(0.06) == ("two",)
    assert barrier.due() == pytest.approx(0.14)


def test_strict_barrier_reports_missed_answers_and_stays_incomplete() -> None:
    barrier = Barrier(strict=True, deadline=10.0)
    barrier.open([ONE, TWO], 0.0)
    assert barrier.missed(9.9) == ()
    assert barrier.missed(10.0) == (ONE, TWO)
    assert not barrier.complete(10.0)


def test_elastic_run_continues_after_a_miss_and_the_third_in_a_row_puts_the_body_to_rest() -> None:
    barrier = elastic()
    for tick in range(3):
        now = float(tick)
        barrier.open([ONE, TWO], now)
        barrier.answer("one", "actions", b"%d" % tick)
        assert barrier.missed(now + 1.0) == (TWO,)
        assert barrier.complete(now + 1.0)
    late = Verdict(agent="two", code="late")
    assert barrier.verdicts() == [late, late, late, Verdict(agent="two", code="rested")]
    barrier.open([ONE, TWO], 4.0)
    assert barrier.awaited == ("one",)


def test_answer_resets_the_count_of_misses() -> None:
    barrier = elastic()
    for tick, answers in enumerate([False, False, True, False, False]):
        barrier.open([TWO], float(tick))
        if answers:
            barrier.answer("two", "actions", b"x")
        else:
            barrier.missed(tick + 1.0)
    barrier.open([TWO], 9.0)
    assert barrier.awaited == ("two",)  # it does not rest


def at_rest() -> Barrier:
    barrier = elastic()
    for tick in range(3):
        barrier.open([ONE, TWO], float(tick))
        barrier.answer("one", "actions", b"%d" % tick)
        barrier.missed(tick + 1.0)
    barrier.verdicts()
    return barrier


def test_body_at_rest_is_back_when_it_answers() -> None:
    barrier = at_rest()
    barrier.open([ONE, TWO], 3.0)
    assert barrier.answer("two", "actions", b"x") == "first"
    assert barrier.verdicts() == [Verdict(agent="two", code="back")]
    barrier.open([ONE, TWO], 3.1)
    assert barrier.awaited == ("one", "two")


def test_body_at_rest_is_back_even_with_a_late_answer() -> None:
    barrier = at_rest()
    barrier.revive("two")
    barrier.revive("two")
    assert barrier.verdicts() == [Verdict(agent="two", code="back")]


def test_if_all_are_at_rest_a_tick_lasts_until_one_answers_or_the_deadline() -> None:
    barrier = elastic()
    for tick in range(3):
        barrier.open([ONE], float(tick))
        barrier.missed(tick + 1.0)
    barrier.open([ONE], 3.0)
    assert not barrier.complete(3.5)
    assert barrier.due() == 4.0
    assert barrier.complete(4.0)
    barrier.answer("one", "actions", b"x")
    assert barrier.complete(3.5)


def test_barrier_does_not_wait_for_an_agent_that_left() -> None:
    barrier = elastic()
    barrier.answer("one", "actions", b"a")
    barrier.cancel("two", "actions")
    assert barrier.complete(0.0)


def test_barrier_waits_for_an_agent_that_joins_while_it_is_open() -> None:
    barrier = elastic()
    barrier.answer("one", "actions", b"a")
    barrier.answer("two", "actions", b"a")
    barrier.add([("three", "actions")])
    assert barrier.awaited == ("three",)


def test_new_run_forgets_rest_and_misses() -> None:
    barrier = at_rest()
    barrier.begin_new_run()
    barrier.open([ONE, TWO], 5.0)
    assert barrier.awaited == ("one", "two")
