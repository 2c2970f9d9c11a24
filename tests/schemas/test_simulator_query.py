"""Of several answers to a query only those of the session that claims the world count."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from typing import Any

import pytest
import zenoh

from intellwheels_experiments.run.endpoints import free_endpoint
from intellwheels_schemas import link
from intellwheels_schemas.keys import Claim, Keys
from intellwheels_schemas.link import Link
from intellwheels_schemas.repliers import mark_of
from intellwheels_schemas.simulator_query import ask_simulator

pytestmark = pytest.mark.process

KEYS = Keys("main")
DEADLINE = 30.0


def until(done: Callable[[], bool]) -> None:
    """Wait until a session knows what others have declared."""
    deadline = time.monotonic() + DEADLINE
    while not done():
        assert time.monotonic() < deadline


def _answer(text: bytes, query: zenoh.Query) -> None:
    query.reply(KEYS.map, text)


def _answers(session: zenoh.Session) -> int:
    try:
        return len(link.query(session, KEYS.map))
    except ConnectionError:  # it knows of nobody who answers yet
        return 0


@pytest.fixture
def sessions() -> Iterator[tuple[zenoh.Session, zenoh.Session, zenoh.Session]]:
    """One that asks, and two that answer with `first` and `second`."""
    meeting = free_endpoint()
    with ExitStack() as stack:
        opened: list[Any] = []
        for where in (Link(listen=(meeting,)), Link(connect=(meeting,)), Link(connect=(meeting,))):
            session = link.open_session(where, threading.Event())
            assert session is not None
            opened.append(stack.enter_context(session))
        for session, text in zip(opened[1:], (b"first", b"second"), strict=True):
            stack.enter_context(session.declare_queryable(KEYS.map, partial(_answer, text)))
        until(lambda: _answers(opened[0]) == 2)
        yield opened[0], opened[1], opened[2]


def claimed(session: zenoh.Session, when: int) -> Any:
    return link.declare_token(session, KEYS.claim(Claim(when, mark_of(str(session.info.zid())))))


def ask(session: zenoh.Session) -> list[bytes]:
    return [answer.data for answer in ask_simulator(session, KEYS, KEYS.map)]


def test_the_session_that_claims_the_world_is_believed(
    sessions: tuple[zenoh.Session, zenoh.Session, zenoh.Session],
) -> None:
    asks, first, second = sessions
    with claimed(second, 1), claimed(first, 2):
        until(lambda: len(link.tokens(asks, KEYS.every_claim)) == 2)
        assert ask(asks) == [b"second"]


def test_without_a_claim_there_is_no_telling(sessions: tuple[zenoh.Session, zenoh.Session, zenoh.Session]) -> None:
    with pytest.raises(ConnectionError, match="expected the answer of the simulator, got answers of others"):
        ask(sessions[0])


def test_a_single_answer_needs_no_claim() -> None:
    session = link.open_session(Link(listen=(free_endpoint(),)), threading.Event())
    assert session is not None
    with session, session.declare_queryable(KEYS.map, partial(_answer, b"only")):
        assert ask(session) == [b"only"]
