from __future__ import annotations

from intellwheels_schemas.keys import Claim, Keys
from intellwheels_schemas.link import Answer
from intellwheels_schemas.repliers import by_simulator, mark_of

KEYS = Keys("main")
OWNER, STRANGER = "0a" * 16, "b" * 32


def answer(replier: str) -> Answer:
    return Answer("iw/v1/main/clock", b"{}", "application/json", True, replier)


def kept(answers: list[Answer], *claims: Claim) -> list[Answer]:
    return by_simulator(answers, KEYS, lambda: [KEYS.claim(claim) for claim in claims])


def test_lone_answer_counts_as_it_comes() -> None:
    assert kept([answer(OWNER)]) == [answer(OWNER)]


def test_of_several_answers_that_of_the_first_claim_counts() -> None:
    answers = [answer(STRANGER), answer(OWNER.lstrip("0"))]
    claims = Claim(2, STRANGER[:16]), Claim(1, OWNER[:16])
    assert kept(answers, *claims) == answers[1:]


def test_without_a_claim_none_of_several_answers_counts() -> None:
    assert kept([answer(STRANGER), answer(OWNER)]) == []


def test_mark_of_a_session_has_sixteen_digits() -> None:
    assert mark_of("a" * 31) == "0" + "a" * 15
