"""The probe of a real process: its life, its output, and what a simulator that disappears leaves behind."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from intellwheels_experiments.conformance.probe import (
    CrewRequest,
    JoinRequest,
    LeaveRequest,
    ProgramEvent,
    ProgramExit,
    TokenChange,
)
from intellwheels_experiments.conformance.scripted_simulator import NetworkProbe
from intellwheels_maps import floor
from intellwheels_schemas.codec import Encoding, decode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.link import Answer, Link, declare_token, open_session, query, tokens
from intellwheels_schemas.messages import Clock, Map, Refused, Result
from tests.e2e.stage import free_port

pytestmark = pytest.mark.process

KEYS = Keys("main")
INSTANCE = "5f0c2a9be1d84377"


@contextmanager
def probing(program: str) -> Iterator[tuple[NetworkProbe, Link]]:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    link = Link("main", listen=(endpoint,))
    command = [sys.executable, "-uc", program]
    with NetworkProbe(command, {"IW_NAME": "chair1"}, link, "chair1", floor("room"), threading.Event()) as probe:
        yield probe, Link("main", connect=(endpoint,))


def event(probe: NetworkProbe, within: float = 20.0) -> ProgramEvent:
    found = probe.next_event(within)
    assert found is not None
    return found


def test_exit_of_the_program_has_its_code_and_its_output() -> None:
    with probing("import os, sys; print(os.environ['IW_NAME']); sys.exit('no place')") as (probe, _):
        probe.start_program()
        assert event(probe) == ProgramExit(1)
        assert probe.output() == "chair1\nno place\n"
        assert probe.next_event(0.1) is None  # the exit is told once


def test_program_that_is_started_again_has_a_new_output() -> None:
    with probing("import signal; print('here'); signal.pause()") as (probe, _):
        for _ in range(2):
            probe.start_program()
            while "here" not in probe.output():
                assert probe.next_event(0.05) is None
            assert probe.output() == "here\n"
            probe.interrupt_program()
            assert event(probe) == ProgramExit(-15)


def test_missing_program_ends_at_once_and_is_named() -> None:
    link = Link("main", listen=(f"tcp/127.0.0.1:{free_port()}",))
    with NetworkProbe(["/no/such/program"], {}, link, "chair1", floor("room"), threading.Event()) as probe:
        probe.start_program()
        assert event(probe) == ProgramExit(127)
        assert probe.output().startswith("/no/such/program: expected a program that can be started, got No such file")


def test_simulator_is_present_answers_and_disappears() -> None:
    stop = threading.Event()
    with probing("") as (probe, link):
        probe.start_simulator()
        session = open_session(link, stop, timeout=20.0)
        assert session is not None
        with session:
            assert tokens(session, KEYS.alive) == [KEYS.alive]
            with declare_token(session, KEYS.token("chair1", "both", INSTANCE)):
                assert event(probe) == TokenChange("both", INSTANCE, True)
            assert event(probe) == TokenChange("both", INSTANCE, False)

            answers: list[bytes] = []
            asker = threading.Thread(target=lambda: answers.append(query(session, KEYS.join("chair1"), b"{}")[0].data))
            asker.start()
            asked = event(probe)
            assert isinstance(asked, JoinRequest)
            assert (asked.data, asked.encoding) == (b"{}", Encoding.JSON.value)
            asked.answer(b"joined", Encoding.JSON, True)
            asker.join(timeout=20.0)
            assert answers == [b"joined"]

            asker = threading.Thread(target=lambda: answers.append(query(session, KEYS.leave("chair1"))[0].data))
            asker.start()
            assert event(probe) == LeaveRequest()
            asker.join(timeout=20.0)
            assert decode(Result, answers[1]).code == "ok"

            asker = threading.Thread(
                target=lambda: answers.append(query(session, KEYS.map, encoding=Encoding.XML)[0].data)
            )
            asker.start()
            assert probe.next_event(0.5) is None
            asker.join(timeout=20.0)
            assert decode(Map, answers[2], Encoding.XML) == floor("room")
        probe.stop_simulator()
        probe.put("measures", b"{}", Encoding.JSON)  # to nobody
        with pytest.raises(ConnectionError):
            open_session(link, stop, timeout=0.1)


def test_clock_is_that_of_the_last_measures_with_fields_that_nobody_knows_too() -> None:
    run = "1" * 16
    plain = f'<Measures Mood="1" Run="{run}" Tick="7" Time="0.35"><Sensors/></Measures>'.encode()
    with probing("") as (probe, client):
        probe.start_simulator()
        probe.put("measures", plain, Encoding.XML)
        session = open_session(client, threading.Event(), timeout=20.0)
        assert session is not None
        answers: list[Answer] = []
        with session:
            asking = threading.Thread(target=lambda: answers.extend(query(session, KEYS.clock, timeout=10.0)))
            asking.start()
            assert probe.next_event(0.5) is None
            asking.join(10.0)
    clock = decode(Clock, answers[0].data)
    assert (clock.run, clock.tick, clock.time) == (run, 7, 0.35)


def test_check_that_is_told_to_stop_stops() -> None:
    stop = threading.Event()
    link = Link("main", listen=(f"tcp/127.0.0.1:{free_port()}",))
    with NetworkProbe([sys.executable, "-c", ""], {}, link, "chair1", floor("room"), stop) as probe:
        stop.set()
        with pytest.raises(ConnectionError, match="stopped before the check was complete"):
            probe.next_event(20.0)


def test_crew_is_told_that_it_is_not_checked() -> None:
    with probing("") as (probe, client):
        probe.start_simulator()
        session = open_session(client, threading.Event())
        assert session is not None
        answers: list[Answer] = []
        with session:
            key = KEYS.crew_join("people")
            asking = threading.Thread(target=lambda: answers.extend(query(session, key, b"{}", timeout=10.0)))
            asking.start()
            assert event(probe) == CrewRequest("people")
            asking.join(10.0)
    (answer,) = answers
    assert not answer.ok
    assert decode(Refused, answer.data).text == (
        "iw-check-agent checks single agents only, not crews; crew 'people' asked to join"
    )
