"""The check's conversation with a program: joins, ticks, and what it notes beside them."""

from __future__ import annotations

import pytest

from intellwheels_experiments.conformance.agent_session import SHOWN, AgentSession, Patience, PointError, shown
from intellwheels_maps import robot
from intellwheels_schemas.messages import Robot
from tests.experiments.conformance.programs import INSTANCE, Program, failures


def session_of(program: Program) -> AgentSession:
    session = AgentSession(program, "main", "chair1", robot("intellwheels"), Patience(start=5.0, answer=1.0, leave=2.0))
    program.start_simulator()
    return session


def test_program_that_has_joined_is_used_again() -> None:
    program = Program()
    session = session_of(program)
    session.require_joined()
    session.require_joined()
    assert (program.starts, session.tick, session.tokens) == (1, 1, {("both", INSTANCE)})


def test_mind_gets_a_body_with_sensors() -> None:
    program = Program()
    program.role = "mind"
    program.document = Robot(role="mind", instance=INSTANCE)
    assert failures(program) == []


def test_join_that_is_asked_again_is_granted_again() -> None:
    program = Program()
    session = session_of(program)
    session.require_joined()
    program.joined = None
    program.ask()
    session.settle()
    assert program.joined is not None
    assert program.joined.session == session.session


def test_end_of_the_program_fails_what_is_expected_of_it() -> None:
    program = Program()
    session = session_of(program)
    session.require_joined()
    program.quit(3)
    with pytest.raises(PointError, match="expected silence, got the end of the program, exit code 3"):
        session.expect_silence(1.0, "silence")


def test_shown_payload_is_short() -> None:
    assert shown(b"{}") == "{}"
    assert shown(b"x" * 1000) == "x" * SHOWN + "... (1000 bytes)"
