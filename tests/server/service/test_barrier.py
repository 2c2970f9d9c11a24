from __future__ import annotations

import pytest

from intellwheels_server.service.barrier import FIRST_REPEAT, Answer, Barrier
from intellwheels_server.world.inputs import Verdict

ONE: Answer = ("one", "actions")
TWO: Answer = ("two", "actions")


def elastic() -> Barrier:
    barrier = Barrier(strict=False, deadline=1.0)
    barrier.open([ONE, TWO], 0.0)
    return barrier


def test_a_barrier_is_complete_when_every_member_has_answered() -> None:
    barrier = elastic()
    assert barrier.answer("one", "actions", b"a") == "first"
    assert not barrier.complete(0.1)
    assert barrier.awaited == ("two",)
    assert barrier.answer("two", "actions", b"b") == "first"
    assert barrier.complete(0.1)


def test_the_first_answer_counts_and_the_same_bytes_are_no_second_answer() -> None:
    barrier = elastic()
    barrier.answer("one", "actions", b"a")
    assert barrier.answer("one", "actions", b"a") == "same"
    assert barrier.answer("one", "actions", b"b") == "again"


def test_an_answer_to_the_tick_before_is_known_by_its_bytes() -> None:
    barrier = elastic()
    barrier.answer("one", "actions", b"a")
    barrier.open([ONE, TWO], 0.1)
    assert barrier.repeats_late("one", "actions", b"a")
    assert not barrier.repeats_late("one", "actions", b"b")
    assert not barrier.repeats("one", "actions", b"a")
    assert not barrier.complete(0.1)
    barrier.answer("one", "actions", b"a")
    assert barrier.repeats("one", "actions", b"a")


def test_unanswered_measures_are_put_again_after_20_ms_then_twice_as_long() -> None:
    barrier = elastic()
    barrier.answer("one", "actions", b"a")
    assert barrier.due() == pytest.approx(FIRST_REPEAT)
    assert barrier.to_repeat(0.019) == ()
    assert barrier.to_repeat(0.02) == ("two",)
    assert barrier.to_repeat(0.059) == ()
    assert barrier.to_repeat(0.06) == ("two",)
    assert barrier.due() == pytest.approx(0.14)


def test_a_strict_barrier_names_who_missed_and_stays_closed() -> None:
    barrier = Barrier(strict=True, deadline=10.0)
    barrier.open([ONE, TWO], 0.0)
    assert barrier.missed(9.9) == ()
    assert barrier.missed(10.0) == (ONE, TWO)
    assert not barrier.complete(10.0)


def test_an_elastic_miss_lets_the_run_go_on_and_the_third_in_a_row_puts_to_rest() -> None:
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


def test_an_answer_between_misses_begins_the_count_anew() -> None:
    barrier = elastic()
    for tick, answers in enumerate([False, False, True, False, False]):
        barrier.open([TWO], float(tick))
        if answers:
            barrier.answer("two", "actions", b"x")
        else:
            barrier.missed(tick + 1.0)
    assert barrier.rested == frozenset()


def at_rest() -> Barrier:
    barrier = elastic()
    for tick in range(3):
        barrier.open([ONE, TWO], float(tick))
        barrier.answer("one", "actions", b"%d" % tick)
        barrier.missed(tick + 1.0)
    barrier.verdicts()
    return barrier


def test_a_body_at_rest_is_back_when_it_answers() -> None:
    barrier = at_rest()
    barrier.open([ONE, TWO], 3.0)
    assert barrier.answer("two", "actions", b"x") == "first"
    assert barrier.verdicts() == [Verdict(agent="two", code="back")]
    barrier.open([ONE, TWO], 3.1)
    assert barrier.awaited == ("one", "two")


def test_a_body_at_rest_is_back_even_when_its_answer_is_late() -> None:
    barrier = at_rest()
    barrier.revive("two")
    barrier.revive("two")
    assert barrier.verdicts() == [Verdict(agent="two", code="back")]


def test_when_all_are_at_rest_a_tick_takes_the_deadline_or_until_one_answers() -> None:
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


def test_who_leaves_is_awaited_no_more() -> None:
    barrier = elastic()
    barrier.answer("one", "actions", b"a")
    barrier.excuse("two", "actions")
    assert barrier.complete(0.0)


def test_who_comes_while_it_is_open_is_awaited_too() -> None:
    barrier = elastic()
    barrier.answer("one", "actions", b"a")
    barrier.answer("two", "actions", b"a")
    barrier.join([("three", "actions")])
    assert barrier.awaited == ("three",)


def test_a_new_run_forgets_rest_and_misses() -> None:
    barrier = at_rest()
    barrier.begin_new_run()
    barrier.open([ONE, TWO], 5.0)
    assert barrier.awaited == ("one", "two")
