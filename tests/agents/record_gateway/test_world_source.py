"""What the loop asks a world for, with a session that answers nothing."""

from __future__ import annotations

import threading

from intellwheels_agents.record_gateway.translator import Entry, Translator
from intellwheels_agents.record_gateway.world_source import WorldSource
from intellwheels_schemas.keys import Keys
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
