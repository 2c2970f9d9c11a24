"""How a query is answered: in the encoding that was asked for, once, and then it is closed."""

from __future__ import annotations

from typing import get_args

import pytest

from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.messages import Quit, Record, Refused, Result, ResultCode
from intellwheels_server.service.arrival import Query

DONE = Result(code="ok")


class Asker:
    """Keeps what it is sent."""

    def __init__(self, encoding: str = "", data: bytes = b"") -> None:
        self.sent: list[tuple[Record, Encoding, bool, str | None]] = []
        self.closed = 0
        self.ask = Query("ctl", "quit", data, encoding, self.send, self.close)

    def send(self, message: Record, encoding: Encoding, ordinary: bool, last: str | None) -> None:
        assert not self.closed
        self.sent.append((message, encoding, ordinary, last))

    def close(self) -> None:
        self.closed += 1


@pytest.mark.parametrize(
    ("encoding", "data", "answered"),
    [
        ("", b"", Encoding.JSON),
        ("application/json;iw.v1", b"{}", Encoding.JSON),
        ("application/xml;iw.v1", b"<Quit/>", Encoding.XML),
        ("", b"<Quit/>", Encoding.XML),
        ("text/plain", b"quit", Encoding.JSON),
        ("image/png", b"\x89PNG", Encoding.JSON),
    ],
)
def test_the_answer_is_written_as_the_question_else_as_json(encoding: str, data: bytes, answered: Encoding) -> None:
    assert Asker(encoding, data).ask.reply_encoding() is answered


def test_a_reply_is_the_only_one() -> None:
    asker = Asker()
    asker.ask.reply(DONE)
    assert (asker.sent, asker.closed) == ([(DONE, Encoding.JSON, True, None)], 1)


def test_a_refusal_is_an_error_reply() -> None:
    asker, refused = Asker("application/xml;iw.v1", b"<Quit/>"), Refused(code="name", text="no")
    asker.ask.refuse(refused)
    assert (asker.sent, asker.closed) == ([(refused, Encoding.XML, False, None)], 1)


def test_several_replies_come_each_on_its_own_key() -> None:
    asker = Asker()
    asker.ask.reply_each({"a": DONE, "b": Quit()})
    assert [(message, last) for message, _, _, last in asker.sent] == [(DONE, "a"), (Quit(), "b")]
    assert asker.closed == 1


def test_a_query_without_parameters_and_wildcards_asks_for_all() -> None:
    ask = Asker().ask
    assert (dict(ask.parameters), ask.has_wildcards, ask.matches("anybody")) == ({}, False, True)


def test_result_that_is_not_ok_is_an_error_reply() -> None:
    for code in get_args(ResultCode):
        asker = Asker()
        asker.ask.reply(Result(run="0" * 16, tick=0, code=code))
        ((_, _, ok, _),) = asker.sent
        assert ok == (code == "ok")
