"""What the loop asks a world for, with a session that answers nothing."""

from __future__ import annotations

import threading
from contextlib import nullcontext
from typing import Any

import pytest

from intellwheels_agents.record_gateway import world_source
from intellwheels_agents.record_gateway.translator import Entry, Translator
from intellwheels_agents.record_gateway.world_source import WorldSource
from intellwheels_schemas import link
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Identity, May
from intellwheels_schemas.rights import denial
from intellwheels_schemas.zenoh_inbox import Put


def test_what_arrives_is_written_in_order_and_nothing_is_asked_when_it_is_over() -> None:
    keys, written, stop = Keys("w"), list[Entry](), threading.Event()
    stop.set()
    translator = Translator(keys, lambda: 0.0)
    source = WorldSource(None, keys, translator, written.append, lambda _: None)
    for number in range(3):
        data = b'{"Seq": %d}' % number
        source.inbox._keep(Put(keys.user("c"), data, "application/json"), len(data))
    translator.wants_map = True
    assert source.work(stop, 0.0)
    assert not source.work(stop, 0.0)
    assert [entry.message for entry in written] == [b'{"Seq":0}', b'{"Seq":1}', b'{"Seq":2}']


class Session:
    """Keeps what is subscribed to."""

    def __init__(self) -> None:
        self.expressions: list[str] = []

    def declare_subscriber(self, expression: str, _: object) -> Any:
        self.expressions.append(expression)
        return nullcontext()


def test_the_router_of_a_lab_lets_a_recorder_subscribe_to_all_that_is_recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link, "watch_tokens", lambda *_: nullcontext())
    session, keys = Session(), Keys("w")
    with WorldSource(session, keys, Translator(keys, lambda: 0.0), lambda _: None, lambda _: None):
        pass
    recorder = Identity(name="recorder", may=(May(role="recorder", world="w"),))
    assert {denial(recorder, expression, "read") for expression in session.expressions} == {""}
    wanted = {"out/*/measures", "out/*/power", "out/*/error", "in/*/actions", "in/*/say", "in/*/pose"}
    assert wanted <= {expression.removeprefix(keys.prefix) for expression in session.expressions}


def test_no_simulator_is_told_once_after_a_moment() -> None:
    keys, lines, stop = Keys("w"), list[str](), threading.Event()
    stop.set()
    source = WorldSource(None, keys, Translator(keys, lambda: 0.0), lambda _: None, lines.append)
    source.work(stop, 0.0)
    assert lines == []
    source._waits_since = -world_source.SOON
    for _ in range(2):
        source.work(stop, 0.0)
    assert lines == ["waiting why='no simulator at iw/v1/w/alive yet'"]
