"""The stand of a real process: its life, its output, and what a simulator's going leaves behind."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from intellwheels_experiments.conformance.contract_points import Asked, Ended, Left, News, Seen
from intellwheels_experiments.conformance.scripted_simulator import NetworkProbe
from intellwheels_maps import floor
from intellwheels_schemas.codec import Encoding, decode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.link import Link, declare_token, open_session, query, tokens
from intellwheels_schemas.messages import Map, Result
from tests.e2e.stage import free_port

pytestmark = pytest.mark.process

KEYS = Keys("main")
INSTANCE = "5f0c2a9be1d84377"


@contextmanager
def standing(program: str) -> Iterator[tuple[NetworkProbe, Link]]:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    link = Link("main", listen=(endpoint,))
    command = [sys.executable, "-uc", program]
    with NetworkProbe(command, {"IW_NAME": "chair1"}, link, "chair1", floor("room"), threading.Event()) as stand:
        yield stand, Link("main", connect=(endpoint,))


def news(stand: NetworkProbe, within: float = 20.0) -> News:
    came = stand.wait(within)
    assert came is not None
    return came


def test_end_of_the_program_comes_with_its_code_and_its_output() -> None:
    with standing("import os, sys; print(os.environ['IW_NAME']); sys.exit('no place')") as (stand, _):
        stand.start()
        assert news(stand) == Ended(1)
        assert stand.printed() == "chair1\nno place\n"
        assert stand.wait(0.1) is None  # it ends once


def test_program_is_told_to_end_and_starts_anew_with_nothing_printed() -> None:
    with standing("import signal; print('here'); signal.pause()") as (stand, _):
        for _ in range(2):
            stand.start()
            while "here" not in stand.printed():
                assert stand.wait(0.05) is None
            assert stand.printed() == "here\n"
            stand.interrupt()
            assert news(stand) == Ended(-15)


def test_program_that_is_not_there_is_an_error_in_words() -> None:
    link = Link("main", listen=(f"tcp/127.0.0.1:{free_port()}",))
    with (
        NetworkProbe(["/no/such/program"], {}, link, "chair1", floor("room"), threading.Event()) as stand,
        pytest.raises(OSError, match="/no/such/program"),
    ):
        stand.start()


def test_simulator_is_present_answers_and_goes() -> None:
    stop = threading.Event()
    with standing("") as (stand, link):
        stand.rise()
        session = open_session(link, stop, timeout=20.0)
        assert session is not None
        with session:
            assert tokens(session, KEYS.alive) == [KEYS.alive]
            with declare_token(session, KEYS.token("chair1", "both", INSTANCE)):
                assert news(stand) == Seen("both", INSTANCE, True)
            assert news(stand) == Seen("both", INSTANCE, False)

            answers: list[bytes] = []
            asker = threading.Thread(target=lambda: answers.append(query(session, KEYS.join("chair1"), b"{}")[0].data))
            asker.start()
            asked = news(stand)
            assert isinstance(asked, Asked)
            assert (asked.data, asked.encoding) == (b"{}", Encoding.JSON.value)
            asked.answer(b"joined", Encoding.JSON, True)
            asker.join(timeout=20.0)
            assert answers == [b"joined"]

            asker = threading.Thread(target=lambda: answers.append(query(session, KEYS.leave("chair1"))[0].data))
            asker.start()
            assert news(stand) == Left()
            asker.join(timeout=20.0)
            assert decode(Result, answers[1]).code == "ok"

            asker = threading.Thread(
                target=lambda: answers.append(query(session, KEYS.map, encoding=Encoding.XML)[0].data)
            )
            asker.start()
            assert stand.wait(0.5) is None
            asker.join(timeout=20.0)
            assert decode(Map, answers[2], Encoding.XML) == floor("room")
        stand.fall()
        stand.put("measures", b"{}", Encoding.JSON)  # to nobody
        with pytest.raises(ConnectionError):
            open_session(link, stop, timeout=0.1)


def test_check_that_is_told_to_stop_stops() -> None:
    stop = threading.Event()
    link = Link("main", listen=(f"tcp/127.0.0.1:{free_port()}",))
    with NetworkProbe([sys.executable, "-c", ""], {}, link, "chair1", floor("room"), stop) as stand:
        stop.set()
        with pytest.raises(ConnectionError, match="told to stop"):
            stand.wait(20.0)
