"""A program for tests of the check: a few lines of Python with a clock of its own. Subclasses have one fault each."""

from __future__ import annotations

from collections import deque
from typing import Literal

from intellwheels_experiments.conformance.agent_session import Patience
from intellwheels_experiments.conformance.contract_points import Outcome, check
from intellwheels_experiments.conformance.probe import (
    ActionsPut,
    JoinRequest,
    ProgramEvent,
    ProgramExit,
    TokenChange,
)
from intellwheels_maps import robot
from intellwheels_schemas.codec import Encoding, decode, encode
from intellwheels_schemas.messages import Actions, Joined, Measures, Refused, Robot

LATENCY = 0.003
INSTANCE = "5f0c2a9be1d84377"
CHAIR = Robot(instance=INSTANCE, top_speed=1.0, length=1.0, width=0.6)


class Program:
    """A program that keeps the contract, and its own `Probe`. A subclass with a fault overrides a method."""

    encoding = Encoding.JSON
    document = CHAIR
    role: Literal["both", "body", "mind"] = "both"

    def __init__(self) -> None:
        self.time = 0.0
        self.events: deque[ProgramEvent] = deque()
        self.simulator = False
        self.alive = False
        self.joined: Joined | None = None
        self.newest = ("", -1)
        self.printed = ""
        self.starts = 0

    # ------------------------------------------------------------ the probe

    def now(self) -> float:
        return self.time

    def start_program(self) -> None:
        self.starts += 1
        self.alive, self.joined, self.newest, self.printed = True, None, ("", -1), ""
        self.meet()

    def interrupt_program(self) -> None:
        if self.alive:
            self.on_sigterm()

    def kill_program(self) -> None:
        self.alive = False
        self.events.clear()

    def output(self) -> str:
        return self.printed

    def start_simulator(self) -> None:
        if not self.simulator:
            self.simulator = True
            if self.alive:
                self.meet()

    def stop_simulator(self) -> None:
        self.simulator = False
        self.events.clear()

    def put(self, kind: Literal["measures", "error"], data: bytes, encoding: Encoding) -> None:
        if self.alive and kind == "measures":
            self.on_measures(decode(Measures, data, encoding, strict=False))

    def next_event(self, timeout: float) -> ProgramEvent | None:
        self.time += LATENCY if self.events else timeout
        return self.events.popleft() if self.events else None

    # ------------------------------------------------------------ the program

    def meet(self) -> None:
        if self.document.instance is not None:
            self.events.append(TokenChange(self.role, self.document.instance, True))
        self.ask()

    def ask(self) -> None:
        self.events.append(JoinRequest(encode(self.document, self.encoding), self.encoding.value, self.on_answer))

    def on_answer(self, data: bytes, encoding: Encoding, granted: bool) -> None:
        if granted:
            self.joined = decode(Joined, data, encoding)
            return
        refused = decode(Refused, data, encoding)
        self.printed = refused.text
        if refused.code == "no-token":
            self.ask()
        else:
            self.quit(1)

    def quit(self, code: int) -> None:
        self.alive = False
        if self.document.instance is not None:
            self.events.append(TokenChange(self.role, self.document.instance, False))
        self.events.append(ProgramExit(code))

    def on_sigterm(self) -> None:
        self.quit(-15)

    def on_measures(self, measures: Measures) -> None:
        if self.joined is None or (measures.run == self.newest[0] and measures.tick < self.newest[1]):
            return
        self.newest = measures.run, measures.tick
        self.act(Actions(run=measures.run, session=self.joined.session, tick=measures.tick, left_motor=0.5))

    def act(self, actions: Actions) -> None:
        self.events.append(ActionsPut(encode(actions, self.encoding), self.encoding.value))


def examine(program: Program) -> list[Outcome]:
    """Return the outcome of every point."""
    patience = Patience(start=5.0, answer=1.0, leave=2.0)
    return list(check(program, "main", "chair1", robot("intellwheels"), patience))


def failures(program: Program) -> list[Outcome]:
    """Return the outcomes of the points that failed."""
    return [outcome for outcome in examine(program) if outcome.passed is False]


def only_failure(program: Program) -> Outcome:
    """Return the outcome of the only point that failed."""
    (failure,) = failures(program)
    return failure
