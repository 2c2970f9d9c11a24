"""The points as a whole: a program without a fault passes them all, and one that does not join is asked no more."""

from __future__ import annotations

import pytest

from intellwheels_experiments.conformance.contract_points import POINTS, described
from intellwheels_schemas.codec import Encoding
from tests.experiments.conformance.programs import Program, examine

NAMES = [
    "join", "refusal", "token", "ticks", "lost", "again", "late", "names", "encoding", "congestion", "say", "reset",
    "restart", "unknown", "hostile", "leave",
]  # fmt: skip


@pytest.mark.parametrize("encoding", [Encoding.JSON, Encoding.XML])
def test_program_that_keeps_the_contract_passes_every_point(encoding: Encoding) -> None:
    program = Program()
    program.encoding = encoding
    outcomes = examine(program)
    assert [outcome.point for outcome in outcomes] == NAMES
    assert [outcome for outcome in outcomes if not outcome.passed] == []
    assert program.starts == 2  # one that is refused, one for all other points


class NeverAsks(Program):
    """Does not ask to join."""

    def ask(self) -> None:
        pass


def test_program_that_does_not_join_is_checked_for_nothing_else() -> None:
    first, *others = examine(NeverAsks())
    assert (first.point, first.passed, first.got) == ("join", False, "none")
    assert {outcome.passed for outcome in others} == {None}


def test_every_point_says_what_a_program_must_do() -> None:
    lines = described().splitlines()
    assert [line.split()[0] for line in lines] == list(POINTS) == NAMES
    assert all(len(line.split()) > 4 and line.endswith(".") for line in lines)
