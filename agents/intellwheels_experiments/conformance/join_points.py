"""The points about joining and leaving. Each returns what it observed, or raises `PointError`."""

from __future__ import annotations

from typing import Final

from intellwheels_experiments.conformance.agent_session import QUIET, AgentSession, PointError, shown
from intellwheels_experiments.conformance.probe import ActionsPut, JoinRequest, LeaveRequest, ProgramExit, TokenChange
from intellwheels_schemas.messages import Refused
from intellwheels_schemas.names import new_hex

ASKS_AGAIN: Final = 10.0
"""Seconds in which a program must ask again after `no-token`."""
REFUSED_FOR: Final = 3.0
"""Seconds in which a refused program must print the text of the refusal, and may end."""


def join(session: AgentSession) -> str:
    """Starts: declares its liveliness token and asks to join with a valid Robot."""
    session.probe.start_program()
    session.pending = session.await_join()
    return f"joins as {session.robot.kind}, {session.encoding.name}"


def refusal(session: AgentSession) -> str:
    """Is refused: prints the text of the refusal and sends no Actions."""
    request, session.pending = session.pending, None
    if request is None:
        session.close()
        session.probe.start_program()
        request = session.await_join()
    text = f"agent '{session.agent}' is already here, says the check {new_hex()}"
    refused = Refused(code="already-here", text=text)
    session.refuse(request, refused)
    deadline = session.probe.now() + REFUSED_FOR
    while session.probe.now() < deadline and session.exit_code is None:
        session.put_next_measures()
        event = session.next_event((ActionsPut, JoinRequest, ProgramExit), 0.1)
        if isinstance(event, ActionsPut):
            raise PointError("no Actions after a refused join", shown(event.data))
        if isinstance(event, JoinRequest):
            session.refuse(event, refused)
    if text not in session.probe.output():
        raise PointError(f"the text of the refusal in its output: {text!r}", "another output, or none")
    outcome = "ends" if session.exit_code is not None else "keeps running without a body"
    session.close()
    return f"prints the text and {outcome}"


def token(session: AgentSession) -> str:
    """Is refused with the code no-token, as its token was late: asks again after a moment."""
    session.close()
    session.probe.start_program()
    session.refuse(session.await_join(), Refused(code="no-token", text="the liveliness token was not found; try again"))
    within = min(ASKS_AGAIN, session.patience.start)
    expected = f"another query to join/{session.agent} within {within:g} s of no-token"
    request = session.next_event((JoinRequest,), within, expected)
    if not isinstance(request, JoinRequest):
        raise PointError(expected, "none")
    session.grant(request)
    return "asked again"


def restart(session: AgentSession) -> str:
    """Loses the simulator, which restarts without memory: joins again, and answers with the new session."""
    session.require_joined()
    session.stop_simulator()
    session.settle()
    session.probe.start_simulator()
    session.grant(session.await_join())
    for _ in range(3):
        session.exchange()
    return "joined again and answered with the new session"


def leave(session: AgentSession) -> str:
    """Gets SIGTERM: removes its token or sends Leave, and sends no Actions after that."""
    session.require_joined()
    session.probe.interrupt_program()
    deadline = session.probe.now() + session.patience.leave
    how = ""
    while not how:
        if session.probe.now() >= deadline:
            raise PointError(f"its token gone, or Leave, within {session.patience.leave:g} s of SIGTERM", "neither")
        session.put_next_measures()
        event = session.next_event((ActionsPut, LeaveRequest, TokenChange, ProgramExit), 0.05)
        if isinstance(event, ActionsPut) and session.read(event).leave:
            how = "put Leave"
        elif isinstance(event, LeaveRequest):
            how = "asked to leave"
        elif not session.tokens:
            how = "its token is gone"
    session.settle()
    # Actions that answer the Measures from here on were put after the program left, in whatever order messages arrive.
    first = session.tick
    end = session.probe.now() + QUIET
    while session.probe.now() < end and session.exit_code is None:
        session.put_next_measures()
        event = session.next_event((ActionsPut, ProgramExit), 0.05)
        if isinstance(event, ActionsPut):
            tick = session.read(event).tick
            if tick is None or tick >= first:
                raise PointError(f"no Actions after it left ({how})", shown(event.data))
    return how
