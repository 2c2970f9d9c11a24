"""The check's points, against programs that are a few lines of Python on a clock of their own."""

from __future__ import annotations

from collections import deque
from typing import Literal

import pytest
from msgspec.structs import replace

from intellwheels_experiments.conformance.contract_points import (
    HOSTILE,
    Acted,
    Asked,
    Check,
    Ended,
    Left,
    News,
    Outcome,
    Patience,
    Seen,
)
from intellwheels_maps import robot
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.messages import Actions, Heard, Joined, Measures, Refused, Robot
from intellwheels_schemas.names import new_hex

LATENCY = 0.003
INSTANCE = "5f0c2a9be1d84377"
CHAIR = Robot(instance=INSTANCE, top_speed=1.0, length=1.0, width=0.6)
POINTS = ["join", "refusal", "ticks", "lost", "again", "late", "reset", "restart", "unknown", "hostile", "leave"]


class Program:
    """A program that keeps the contract, and the stand it is on; each fault is another method."""

    encoding = Encoding.JSON
    document = CHAIR
    role: Literal["both", "body", "mind"] = "both"

    def __init__(self) -> None:
        self.time = 0.0
        self.news: deque[News] = deque()
        self.up = False
        self.alive = False
        self.joined: Joined | None = None
        self.newest = ("", -1)
        self.said = ""
        self.starts = 0

    # ------------------------------------------------------------ the stand

    def now(self) -> float:
        return self.time

    def start(self) -> None:
        self.starts += 1
        self.alive, self.joined, self.newest, self.said = True, None, ("", -1), ""
        self.meet()

    def interrupt(self) -> None:
        if self.alive:
            self.told_to_end()

    def end(self) -> None:
        self.alive = False
        self.news.clear()

    def printed(self) -> str:
        return self.said

    def rise(self) -> None:
        if not self.up:
            self.up = True
            if self.alive:
                self.meet()

    def fall(self) -> None:
        self.up = False
        self.news.clear()

    def put(self, kind: Literal["measures", "error"], data: bytes, encoding: Encoding) -> None:
        if self.alive and kind == "measures":
            self.measured(decode(Measures, data, encoding, strict=False))

    def wait(self, seconds: float) -> News | None:
        self.time += LATENCY if self.news else seconds
        return self.news.popleft() if self.news else None

    # ------------------------------------------------------------ the program

    def meet(self) -> None:
        if self.document.instance is not None:
            self.news.append(Seen(self.role, self.document.instance, True))
        self.ask()

    def ask(self) -> None:
        self.news.append(Asked(encode(self.document, self.encoding), self.encoding.value, self.answered))

    def answered(self, data: bytes, encoding: Encoding, granted: bool) -> None:
        if granted:
            self.joined = decode(Joined, data, encoding)
            return
        self.said = decode(Refused, data, encoding).text
        self.quit(1)

    def quit(self, code: int) -> None:
        self.alive = False
        if self.document.instance is not None:
            self.news.append(Seen(self.role, self.document.instance, False))
        self.news.append(Ended(code))

    def told_to_end(self) -> None:
        self.quit(-15)

    def measured(self, measures: Measures) -> None:
        if self.joined is None or (measures.run == self.newest[0] and measures.tick < self.newest[1]):
            return
        self.newest = measures.run, measures.tick
        self.act(Actions(run=measures.run, session=self.joined.session, tick=measures.tick, left_motor=0.5))

    def act(self, actions: Actions) -> None:
        self.news.append(Acted(encode(actions, self.encoding), self.encoding.value))


def examine(program: Program) -> list[Outcome]:
    patience = Patience(start=5.0, answer=1.0, leave=2.0)
    return list(Check(program, "main", "chair1", robot("intellwheels"), patience).run())


def failures(program: Program) -> list[Outcome]:
    return [outcome for outcome in examine(program) if outcome.passed is False]


@pytest.mark.parametrize("encoding", [Encoding.JSON, Encoding.XML])
def test_program_that_keeps_the_contract_passes_every_point(encoding: Encoding) -> None:
    program = Program()
    program.encoding = encoding
    outcomes = examine(program)
    assert [outcome.point for outcome in outcomes] == POINTS
    assert [outcome for outcome in outcomes if not outcome.passed] == []
    assert program.starts == 2  # one that is refused, one for all the rest


class Remembers(Program):
    """Answers the same tick with other bytes."""

    seq = 0

    def act(self, actions: Actions) -> None:
        self.seq += 1
        super().act(Actions(run=actions.run, session=actions.session, tick=actions.tick, seq=self.seq))


class AnswersOnce(Program):
    """Believes that no put is ever lost."""

    def measured(self, measures: Measures) -> None:
        if (measures.run, measures.tick) != self.newest:
            super().measured(measures)


class ForgetsItsSession(Program):
    """Stays with the session it had first."""

    first: str | None = None

    def act(self, actions: Actions) -> None:
        self.first = self.first or actions.session
        super().act(Actions(run=actions.run, session=self.first, tick=actions.tick))

    def start(self) -> None:
        self.first = None
        super().start()


class StaysAway(Program):
    """Does not join again."""

    def rise(self) -> None:
        self.up = True


class Ends(Program):
    """Takes the simulator's end for its own."""

    def fall(self) -> None:
        super().fall()
        if self.alive:
            self.quit(3)


class Obeys(Program):
    """Takes what it hears for a command."""

    def measured(self, measures: Measures) -> None:
        if not any("kill" in heard.text for heard in measures.message):
            super().measured(measures)


class Deaf(Program):
    """Ignores being told to end."""

    def told_to_end(self) -> None:
        pass


class SaysGoodbye(Program):
    """Leaves, and is silent but alive."""

    def told_to_end(self) -> None:
        self.news.append(Left())
        self.joined = None


class Mumbles(Program):
    """Refused, it shows nothing."""

    def printed(self) -> str:
        return ""


@pytest.mark.parametrize(
    ("program", "point", "got"),
    [
        (Remembers(), "again", '"Seq":'),
        (AnswersOnce(), "again", "nothing"),
        (ForgetsItsSession(), "restart", '"Session":'),
        (StaysAway(), "restart", "none"),
        (Ends(), "restart", "the program's end, exit code 3"),
        (Obeys(), "hostile", "nothing to"),
        (Deaf(), "leave", "it is here as before"),
        (Mumbles(), "refusal", "others, or none"),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, Program) else None,
)
def test_fault_fails_its_point_only(program: Program, point: str, got: str) -> None:
    (failure,) = failures(program)
    assert failure.point == point
    assert got in failure.got


def test_leaving_by_a_query_is_leaving() -> None:
    assert examine(SaysGoodbye())[-1] == Outcome("leave", True, "asked to leave", "")


class Behind(Program):
    """Always answers the tick before."""

    def act(self, actions: Actions) -> None:
        super().act(Actions(run=actions.run, session=actions.session, tick=max((actions.tick or 0) - 1, 0)))


class Wild(Program):
    """Gives more power than there is."""

    def act(self, actions: Actions) -> None:
        self.news.append(Acted(b'{"LeftMotor":1.5}', self.encoding.value))


@pytest.mark.parametrize(
    ("program", "got"), [(Behind(), '"Tick":0'), (Wild(), "Actions.LeftMotor: expected a number in [-1, 1], got 1.5")]
)
def test_wrong_answers_fail_from_the_first_ticks_on(program: Program, got: str) -> None:
    outcomes = examine(program)
    assert [outcome.passed for outcome in outcomes[:3]] == [True, True, False]
    assert got in outcomes[2].got


@pytest.mark.parametrize(
    ("document", "expected", "got"),
    [
        (replace(CHAIR, name="chair2"), "absent or 'chair1'", "'chair2'"),
        (replace(CHAIR, instance=None), "Robot.Instance", "none"),
        (replace(CHAIR, top_speed=0.0), "lockstep awaits", "need not answer"),
        (replace(CHAIR, role="body"), "both or mind", "body"),
        (replace(CHAIR, instance="0" * 16), f"the token in/chair1/alive/both/{'0' * 16}", "none"),
    ],
)
def test_join_that_a_simulator_would_refuse_fails_and_nothing_else_is_played(
    document: Robot, expected: str, got: str
) -> None:
    program = Program()
    program.document = document
    if document.instance == "0" * 16:
        program.meet = program.ask  # type: ignore[method-assign] # no token
    first, *others = examine(program)
    assert first.passed is False
    assert expected in first.expected
    assert got in first.got
    assert {outcome.passed for outcome in others} == {None}


def test_joining_as_mind_is_told_of_a_body_with_sensors() -> None:
    program = Program()
    program.role = "mind"
    program.document = Robot(role="mind", instance=INSTANCE)
    assert failures(program) == []


def test_unreadable_join_is_refused_with_the_place() -> None:
    program = Program()
    program.ask = lambda: program.news.append(  # type: ignore[method-assign]
        Asked(b'{"TopSpeed":"fast"}', Encoding.JSON.value, program.answered)
    )
    first = examine(program)[0]
    assert first.got.startswith("Robot.TopSpeed: expected")


@pytest.mark.parametrize("text", HOSTILE)
@pytest.mark.parametrize("encoding", [Encoding.JSON, Encoding.XML])
def test_hostile_texts_are_texts_that_a_simulator_may_send(text: str, encoding: Encoding) -> None:
    heard = Heard(sender="stranger", tick=1, distance=1.0, text=text)
    measures = Measures(run=new_hex(), tick=2, time=0.1, message=(heard,))
    assert decode(Measures, encode(measures, encoding), encoding) == measures
