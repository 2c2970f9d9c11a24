"""The points about joining and leaving, against programs with one fault."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from intellwheels_experiments.conformance.contract_points import Outcome
from intellwheels_experiments.conformance.probe import JoinRequest, LeaveRequest
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import Actions, Robot
from tests.experiments.conformance.programs import CHAIR, Program, examine, only_failure


class KeepsItsSession(Program):
    """Names its first session for ever."""

    first: str | None = None

    def act(self, actions: Actions) -> None:
        self.first = self.first or actions.session
        super().act(Actions(run=actions.run, session=self.first, tick=actions.tick))

    def start_program(self) -> None:
        self.first = None
        super().start_program()


class StaysAway(Program):
    """Does not join again."""

    def start_simulator(self) -> None:
        self.simulator = True


class Ends(Program):
    """Ends when the simulator does."""

    def stop_simulator(self) -> None:
        super().stop_simulator()
        if self.alive:
            self.quit(3)


class Deaf(Program):
    """Ignores SIGTERM."""

    def on_sigterm(self) -> None:
        pass


class Silent(Program):
    """Prints nothing when it is refused."""

    def output(self) -> str:
        return ""


class GivesUp(Program):
    """Ends when its token was late."""

    def on_answer(self, data: bytes, encoding: Encoding, granted: bool) -> None:
        super().on_answer(data, encoding, granted)
        if not granted and self.alive:
            self.events.clear()
            self.quit(1)


class Waits(Program):
    """Waits for ever when its token was late."""

    def on_answer(self, data: bytes, encoding: Encoding, granted: bool) -> None:
        super().on_answer(data, encoding, granted)
        if not granted and self.alive:
            self.events.clear()


@pytest.mark.parametrize(
    ("program", "point", "got"),
    [
        (GivesUp(), "token", "the end of the program, exit code 1"),
        (Waits(), "token", "none"),
        (KeepsItsSession(), "restart", '"Session":'),
        (StaysAway(), "restart", "none"),
        (Ends(), "restart", "the end of the program, exit code 3"),
        (Deaf(), "leave", "neither"),
        (Silent(), "refusal", "another output, or none"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, Program) else None,
)
def test_fault_fails_its_point_only(program: Program, point: str, got: str) -> None:
    failure = only_failure(program)
    assert failure.point == point
    assert got in failure.got


class SaysGoodbye(Program):
    """Leaves with a query, and stays alive without a word."""

    def on_sigterm(self) -> None:
        self.events.append(LeaveRequest())
        self.joined = None


def test_leaving_by_a_query_is_leaving() -> None:
    assert examine(SaysGoodbye())[-1] == Outcome("leave", True, "asked to leave", "")


@pytest.mark.parametrize(
    ("document", "expected", "got"),
    [
        (replace(CHAIR, name="chair2"), "absent or 'chair1'", "'chair2'"),
        (replace(CHAIR, instance=None), "Robot.Instance", "none"),
        (replace(CHAIR, top_speed=0.0), "lockstep waits for", "lockstep does not wait for"),
        (replace(CHAIR, role="body"), "both or mind", "body"),
        (replace(CHAIR, instance="0" * 16), f"the token in/chair1/alive/both/{'0' * 16}", "none"),
    ],
)
def test_join_that_a_simulator_would_refuse_fails(document: Robot, expected: str, got: str) -> None:
    program = Program()
    program.document = document
    if document.instance == "0" * 16:
        program.meet = program.ask  # type: ignore[method-assign] # no token
    first, *others = examine(program)
    assert first.passed is False
    assert expected in first.expected
    assert got in first.got
    assert {outcome.passed for outcome in others} == {None}


def test_unreadable_join_is_refused_with_the_place() -> None:
    program = Program()
    program.ask = lambda: program.events.append(  # type: ignore[method-assign]
        JoinRequest(b'{"TopSpeed":"fast"}', Encoding.JSON.value, program.on_answer)
    )
    first = examine(program)[0]
    assert first.got.startswith("Robot.TopSpeed: expected")
