"""What every peer of the agents does with its session."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from types import SimpleNamespace
from typing import cast

import pytest
import zenoh

from intellwheels_agents.simulator_session import (
    ARRIVAL_LIMIT,
    QUEUE_LIMIT,
    Arrivals,
    ask,
    fetch_map,
    leave,
    run_in_session,
)
from intellwheels_schemas import link
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Map
from intellwheels_schemas.zenoh_inbox import Presence
from tests.e2e.stage import free_port

KEYS = Keys("main")


def sample(size: int) -> zenoh.Sample:
    return cast("zenoh.Sample", SimpleNamespace(payload=b"x" * size, key_expr="iw/v1/main/out/a/measures"))


def test_too_long_and_too_many_arrivals_are_dropped_and_told(capsys: pytest.CaptureFixture[str]) -> None:
    arrivals: Arrivals[None] = Arrivals()
    arrivals.store(sample(ARRIVAL_LIMIT + 1))
    assert arrivals.empty()
    for _ in range(QUEUE_LIMIT + 2):
        arrivals.store(sample(1))
    assert arrivals.qsize() == QUEUE_LIMIT
    assert arrivals.dropped == 3
    arrivals.report_dropped()
    assert capsys.readouterr().err.splitlines() == [
        "dropped key=iw/v1/main/out/a/measures why='1048577 bytes, 0 waiting; expected at most 1048576 and 1024'",
        "overflowed arrivals=3",
    ]


def test_presence_of_the_simulator_waits_among_the_arrivals() -> None:
    arrivals: Arrivals[None] = Arrivals()
    for kind in (zenoh.SampleKind.PUT, zenoh.SampleKind.DELETE):
        arrivals.notice(cast("zenoh.Sample", SimpleNamespace(key_expr=KEYS.alive, kind=kind)))
    assert [arrivals.get(), arrivals.get()] == [Presence(KEYS.alive, True), Presence(KEYS.alive, False)]


@pytest.fixture
def session() -> Iterator[zenoh.Session]:
    opened = link.open_session(link.Link(listen=(f"tcp/127.0.0.1:{free_port()}",)), threading.Event())
    assert opened is not None
    with opened:
        yield opened


@pytest.mark.process
def test_without_a_simulator_there_is_no_answer_and_a_leave_says_so(
    session: zenoh.Session, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ask(session, KEYS, KEYS.join("a"), b"{}", Encoding.JSON, 0.1) == []
    leave(session, KEYS.leave("a"), b"{}", Encoding.JSON)
    assert "unanswered request=leave why=" in capsys.readouterr().err


@pytest.mark.process
def test_map_is_what_the_simulator_answers_and_is_checked(session: zenoh.Session) -> None:
    floor = Map(format="iw.v1", name="room")
    answers = [encode(floor), b"{"]

    def reply(query: zenoh.Query) -> None:
        query.reply(KEYS.map, answers.pop(0))

    with session.liveliness().declare_token(KEYS.alive), session.declare_queryable(KEYS.map, reply):
        assert fetch_map(session, KEYS) == floor
        with pytest.raises(WireError):
            fetch_map(session, KEYS)


@pytest.mark.process
def test_run_has_a_session_and_the_time_that_is_left_or_ends_with_words(capsys: pytest.CaptureFixture[str]) -> None:
    stop = threading.Event()
    here = link.Link(listen=(f"tcp/127.0.0.1:{free_port()}",))
    left: list[float] = []

    def run(session: zenoh.Session, seconds: float) -> int:
        assert not session.is_closed()
        left.append(seconds)
        return 7

    assert run_in_session(here, 30.0, stop, run) == 7
    assert 0.0 < left[0] <= 30.0
    nowhere = link.Link(connect=(f"tcp/127.0.0.1:{free_port()}",))
    assert run_in_session(nowhere, 0.3, stop, run) == 1
    assert capsys.readouterr().err.strip()
    stop.set()
    assert run_in_session(nowhere, 30.0, stop, run) == 0
    assert len(left) == 1
