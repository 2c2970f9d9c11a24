"""The points about answering Measures tick by tick. Each returns what it observed, or raises `PointError`."""

from __future__ import annotations

from typing import Final

from intellwheels_experiments.conformance.agent_session import QUIET, AgentSession, PointError, shown
from intellwheels_experiments.conformance.probe import ActionsPut

TICKS: Final = 20
"""Ticks of the point `ticks`."""


def ticks(session: AgentSession) -> str:
    """Gets 20 Measures: answers each with Actions that have its tick, run and session."""
    session.require_joined()
    slowest = max(session.exchange() for _ in range(TICKS))
    return f"{TICKS} ticks answered, the slowest in {1000 * slowest:.0f} ms"


def lost(session: AgentSession) -> str:
    """Gets no Measures for some ticks: answers the next ones."""
    session.require_joined()
    session.tick += 2
    session.exchange()
    return "two ticks were left out, the next one was answered"


def again(session: AgentSession) -> str:
    """Gets the same Measures again, as if its answer had been lost: answers with the same bytes again."""
    session.require_joined()
    session.exchange()
    first = session.last_answer
    session.settle()
    session.put_measures(session.last_measures)
    expected = f"an answer to the repeated tick {session.tick - 1}"
    event = session.next_event((ActionsPut,), session.patience.answer, expected)
    if not isinstance(event, ActionsPut):
        raise PointError("the same bytes again", "nothing")
    if event.data != first:
        raise PointError(f"the same bytes again, {shown(first)}", shown(event.data))
    return "the same bytes again"


def late(session: AgentSession) -> str:
    """Gets old Measures after newer ones, and an Error: does not answer the old ones, and answers the next Measures."""
    session.require_joined()
    old = session.measures()
    session.tick += 1
    session.exchange()
    session.settle()
    session.put_measures(old)
    session.expect_silence(QUIET, f"no answer to tick {session.tick - 2} after tick {session.tick - 1}")
    session.put_error("late", "Actions.Tick: expected the present tick, got an older one")
    session.exchange()
    return "an old tick was not answered, the next one was"


def reset(session: AgentSession) -> str:
    """Gets Measures of a new run, from tick 0: answers with the id of the new run."""
    session.require_joined()
    before = session.run
    session.begin_run()
    for _ in range(3):
        session.exchange()
    return f"after run {before}, run {session.run} was answered from tick 0 on"
