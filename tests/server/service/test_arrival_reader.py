from __future__ import annotations

from typing import Any, cast

import pytest

from intellwheels_schemas import codec, zenoh_inbox
from intellwheels_schemas.codec import Encoding
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Map, Quit
from intellwheels_server.service import arrival_reader
from intellwheels_server.service.arrival import Put, Query
from intellwheels_server.service.arrival_reader import MAX_SHOWN, ArrivalReader


def test_unknown_keys_are_not_remembered() -> None:
    reader = ArrivalReader(Keys("main"))
    for number in range(10):
        stray = reader.read(zenoh_inbox.Put(f"iw/v1/main/in/{'x' * 60_000}{number}/actions", b"{}", ""))
        assert stray == Put("", "stray", b"", "", key=f"in/{'x' * (MAX_SHOWN - 3)}")
    assert reader.read(zenoh_inbox.Put("iw/v1/main/in/chair1/actions", b"{}", "")) == Put(
        "chair1", "actions", b"{}", ""
    )
    assert list(reader._known) == ["iw/v1/main/in/chair1/actions"]


def test_message_on_a_mistyped_key_is_stray_and_one_of_another_part_of_the_world_is_ignored() -> None:
    reader = ArrivalReader(Keys("main"))
    assert reader.read(zenoh_inbox.Put("iw/v1/main/in/a/acton", b"{}", "")) == Put(
        "a", "stray", b"", "", key="in/a/acton"
    )
    assert reader.read(zenoh_inbox.TooLong("iw/v1/main/user/a/b", 5)) == Put("a", "stray", b"", "", key="user/a/b")
    assert reader.read(zenoh_inbox.Put("iw/v1/main/out/a/measures", b"{}", "")) is None


@pytest.mark.parametrize("key", ["iw/v1/main/*", "iw/v1/*/clock", "iw/v1/**"])
def test_query_with_wildcards_is_about_the_key_of_its_queryable_and_answered_there(key: str) -> None:
    sent: list[str | None] = []

    class Ask(zenoh_inbox.Ask):
        def reply(self, data: bytes, encoding: Encoding, key: str | None = None) -> None:
            sent.append(key)

        def close(self) -> None:
            pass

    ask = Ask(key, "", b"", "", cast(Any, None), "iw/v1/main/clock")
    query = ArrivalReader(Keys("main")).read(ask)
    assert isinstance(query, Query)
    assert (query.topic, query.has_wildcards) == ("clock", True)
    query.reply(Quit())
    assert sent == ["iw/v1/main/clock"]


def test_map_is_encoded_once_in_each_encoding(monkeypatch: pytest.MonkeyPatch) -> None:
    sent: list[bytes] = []
    made: list[Encoding] = []

    def encode(message: Map, encoding: Encoding) -> bytes:
        made.append(encoding)
        return codec.encode(message, encoding)

    class Ask(zenoh_inbox.Ask):
        def reply(self, data: bytes, encoding: Encoding, key: str | None = None) -> None:
            sent.append(data)

        def close(self) -> None:
            pass

    monkeypatch.setattr(arrival_reader, "encode", encode)
    reader = ArrivalReader(Keys("main"))
    first, second = Map(format="iw.v1", name="first"), Map(format="iw.v1", name="second")
    for floor in (first, first, second):
        for encoding in (Encoding.JSON, Encoding.XML):
            ask = Ask("iw/v1/main/map", "", b"", encoding.value, cast(Any, None), "iw/v1/main/map")
            query = reader.read(ask)
            assert isinstance(query, Query)
            query.reply(floor)
    assert made == [Encoding.JSON, Encoding.XML] * 2
    assert sent == [
        codec.encode(floor, encoding) for floor in (first, first, second) for encoding in (Encoding.JSON, Encoding.XML)
    ]
