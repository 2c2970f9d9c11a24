"""One mind in one run: which measures it is asked about, and what is encoded of its answers."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from intellwheels_agents.mind_error import MindError
from intellwheels_agents.mind_run import Answer, MindRun
from intellwheels_schemas.codec import Encoding, decode
from intellwheels_schemas.messages import Actions, Heard, Measures, Pose

RUN, SESSION = "a" * 16, "b" * 16


class Fixed:
    """A mind with a fixed answer that records what it was asked."""

    def __init__(self, answer: Actions | Pose | None) -> None:
        self.answer = answer
        self.asked: list[Measures] = []

    def decide(self, measures: Measures) -> Actions:
        self.asked.append(measures)
        return self.answer  # type: ignore[return-value]


def started(mind: Fixed, *, publishes_actions: bool = True, awaited: bool = True) -> MindRun:
    return MindRun(
        mind, run=RUN, session=SESSION, encoding=Encoding.JSON, say_limit=5,
        publishes_actions=publishes_actions, awaited=awaited,
    )  # fmt: skip


def measures(tick: int, run: str = RUN, *texts: str) -> Measures:
    heard = tuple(Heard(sender="door", tick=tick, distance=1.0, text=text) for text in texts)
    return Measures(run=run, tick=tick, time=tick * 0.05, message=heard)


def test_answer_is_encoded_with_run_session_tick_and_sequence_number() -> None:
    current = started(Fixed(Actions(left_motor=0.5, right_motor=2.0, say="follow me")))
    current.answer([measures(3)], b"first")
    answer = current.answer([measures(4)], b"second")
    assert (current.tick, current.payload, current.last) == (4, b"second", answer)
    assert decode(Actions, answer.payload) == Actions(
        run=RUN, session=SESSION, tick=4, seq=1, left_motor=0.5, right_motor=1.0, say="follo"
    )


def test_messages_of_skipped_ticks_reach_the_mind_but_not_those_of_another_run() -> None:
    mind = Fixed(Actions())
    current = started(mind)
    current.answer([measures(0)], b"")
    current.answer([measures(9, "c" * 16, "old"), measures(1, RUN, "one"), measures(2, RUN, "two")], b"")
    assert [message.text for message in mind.asked[-1].message] == ["one", "two"]
    assert mind.asked[-1].tick == 2


def test_skipped_ticks_are_counted_from_the_first_answer_on() -> None:
    current = started(Fixed(Actions()))
    assert current.missed_before(7) == 0
    current.answer([measures(7)], b"")
    assert [current.missed_before(tick) for tick in (7, 8, 10)] == [0, 0, 2]


@pytest.mark.parametrize(
    ("answer", "publishes_actions", "awaited"),
    [(None, False, True), (Actions(left_motor=0.1), False, True), (Actions(), True, False)],
)
def test_nothing_is_sent_without_an_answer_a_mind_or_a_waiting_lockstep(
    answer: Actions | None, publishes_actions: bool, awaited: bool
) -> None:
    current = started(Fixed(answer), publishes_actions=publishes_actions, awaited=awaited)
    assert current.answer([measures(0)], b"") == Answer(b"")


def test_leaving_is_part_of_the_answer() -> None:
    assert started(Fixed(Actions(leave=True))).answer([measures(0)], b"").leaves


def test_text_with_control_characters_is_a_bug_of_the_mind() -> None:
    with pytest.raises(MindError, match="expected text without control characters"):
        started(Fixed(Actions(say="a\x07b"))).answer([measures(0)], b"")


@pytest.mark.parametrize("number", [np.float64(0.25), np.float32(0.25), np.int64(0), True, Fraction(1, 4)])
def test_numbers_of_other_libraries_are_numbers(number: Any) -> None:
    answer = started(Fixed(Actions(left_motor=number, right_motor=np.clip(2.0, -1.0, 1.0)))).answer([measures(0)], b"")
    sent = decode(Actions, answer.payload)
    assert (sent.left_motor, sent.right_motor) == (float(number), 1.0)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (None, "expected Actions, got None; is a `return` missing?"),
        (5, r"expected Actions, got 5 \(int\)"),
        (Actions(left_motor="fast"), r"expected a number for left_motor, got 'fast' \(str\)"),  # type: ignore[arg-type]
        (Actions(right_motor=(1, 2)), "expected a number for right_motor"),  # type: ignore[arg-type]
        (Actions(say=5), r"expected text for say, got 5 \(int\)"),  # type: ignore[arg-type]
        (Actions(mode=object()), r"expected Actions that can be sent \("),  # type: ignore[arg-type]
    ],
)
def test_wrong_answer_is_named_with_its_place(answer: Any, words: str) -> None:
    line = Fixed.decide.__code__.co_firstlineno
    with pytest.raises(MindError, match=rf"^\S*test_mind_run\.py:{line}: decide: {words}"):
        started(Fixed(answer)).answer([measures(0)], b"")


def test_exception_of_a_mind_is_named_with_its_line() -> None:
    class Fails:
        def decide(self, measures: Measures) -> Actions:
            return Actions(left_motor=1.0 / measures.tick)

    with pytest.raises(MindError, match=r"test_mind_run\.py:\d+: decide: ZeroDivisionError: float division by zero$"):
        started(Fails()).answer([measures(0)], b"")  # type: ignore[arg-type]
