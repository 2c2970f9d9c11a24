"""The points about answering Measures, against programs with one fault."""

from __future__ import annotations

import pytest

from intellwheels_experiments.conformance.probe import ActionsPut
from intellwheels_schemas.messages import Actions, Measures
from tests.experiments.conformance.programs import Program, examine, only_failure


class Counts(Program):
    """Answers the same tick with other bytes."""

    seq = 0

    def act(self, actions: Actions) -> None:
        self.seq += 1
        super().act(Actions(run=actions.run, session=actions.session, tick=actions.tick, seq=self.seq))


class AnswersOnce(Program):
    """Assumes that no message is ever lost."""

    def on_measures(self, measures: Measures) -> None:
        if (measures.run, measures.tick) != self.newest:
            super().on_measures(measures)


@pytest.mark.parametrize(
    ("program", "got"), [(Counts(), '"Seq":'), (AnswersOnce(), "nothing")], ids=["Counts", "AnswersOnce"]
)
def test_program_that_does_not_repeat_its_answer_fails_that_point_only(program: Program, got: str) -> None:
    failure = only_failure(program)
    assert failure.point == "again"
    assert got in failure.got


class Behind(Program):
    """Always answers the tick before."""

    def act(self, actions: Actions) -> None:
        super().act(Actions(run=actions.run, session=actions.session, tick=max((actions.tick or 0) - 1, 0)))


class Wild(Program):
    """Asks for more than full power."""

    def act(self, actions: Actions) -> None:
        self.events.append(ActionsPut(b'{"LeftMotor":1.5}', self.encoding.value))


@pytest.mark.parametrize(
    ("program", "got"), [(Behind(), '"Tick":0'), (Wild(), "Actions.LeftMotor: expected a number in [-1, 1], got 1.5")]
)
def test_wrong_answers_fail_from_the_first_ticks_on(program: Program, got: str) -> None:
    outcomes = examine(program)
    assert [outcome.passed for outcome in outcomes[:4]] == [True, True, True, False]
    assert got in outcomes[3].got
