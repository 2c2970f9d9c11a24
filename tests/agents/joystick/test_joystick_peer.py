"""A joystick that ends leaves no lease behind, not even one that was being granted."""

from __future__ import annotations

import queue
import threading
from typing import Any, cast

import pytest

from intellwheels_agents.joystick.input_state import NEUTRAL, InputState
from intellwheels_agents.joystick.joystick_peer import _Loop
from intellwheels_schemas.codec import encode
from intellwheels_schemas.messages import Error, Result, Take
from intellwheels_schemas.zenoh_inbox import Inbox, Put

LEASE = "a" * 16


class Simulator:
    """Grants what is asked for when it is told to."""

    def __init__(self) -> None:
        self.answers: queue.SimpleQueue[Result | None] = queue.SimpleQueue()
        self.back: list[Take] = []

    def start(self, take: Take) -> None:
        pass

    def grant(self) -> None:
        self.answers.put(Result(run="0" * 16, tick=0, code="ok", lease=LEASE))

    def ask(self, take: Take) -> Result:
        self.back.append(take)
        return Result(run="0" * 16, tick=0, code="ok")


class Brief:
    """Ends after one state; the answer comes in between."""

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator
        self._states: list[InputState | None] = [NEUTRAL, None]

    def wait(self, seconds: float) -> None:
        self._simulator.grant()

    def state(self, now: float, time: float | None) -> InputState | None:
        return self._states.pop(0)


def test_a_lease_granted_at_the_end_is_given_back(capsys: pytest.CaptureFixture[str]) -> None:
    simulator = Simulator()
    loop = _Loop("chair1", Brief(simulator), cast(Any, simulator), Inbox(), cast(Any, None), take=True)
    assert loop.run(threading.Event()) == 0
    assert [(take.agent, take.lease, take.seconds) for take in simulator.back] == [("chair1", LEASE, 0.0)]
    assert capsys.readouterr().out.splitlines()[-2:] == ["released agent=chair1", "ended agent=chair1"]


class Short:
    """Ends after one state."""

    def __init__(self) -> None:
        self._states: list[InputState | None] = [None]

    def wait(self, seconds: float) -> None:
        pass

    def state(self, now: float, time: float | None) -> InputState | None:
        return self._states.pop(0)


class Nowhere:
    """A publisher without a network."""

    def put(self, payload: bytes) -> None:
        pass


def test_every_line_is_announced_to_the_source_that_shows_a_caption(capsys: pytest.CaptureFixture[str]) -> None:
    def leave_caption() -> None:
        print("<", end="")

    loop = _Loop(
        "chair1", Short(), cast(Any, None), Inbox(), cast(Any, Nowhere()), take=False, before_line=leave_caption
    )
    assert loop.run(threading.Event()) == 0
    assert capsys.readouterr().out == "<ready agent=chair1\n<ended agent=chair1\n"


def test_error_about_user_input_is_told_and_others_are_the_agents_own(capsys: pytest.CaptureFixture[str]) -> None:
    inbox = Inbox()
    for where, text in (("UserInput", "takes none"), ("UserInput", "takes none"), ("Actions.LeftMotor", "too fast")):
        error = Error(run="0" * 16, tick=0, code="role", where=where, text=text)
        inbox._keep(Put("iw/v1/main/out/chair1/error", encode(error), "application/json"), 1)
    loop = _Loop("chair1", Short(), cast(Any, None), inbox, cast(Any, Nowhere()), take=False)
    assert loop.run(threading.Event()) == 0
    told = capsys.readouterr().err
    assert told.count("iw-joystick: ignored agent=chair1 code=role why='takes none'") == 1  # the same is not repeated
    assert "too fast" not in told
