from __future__ import annotations

from intellwheels_schemas import zenoh_inbox
from intellwheels_schemas.keys import Keys
from intellwheels_server.service.arrival import Put
from intellwheels_server.service.arrival_reader import ArrivalReader


def test_unknown_keys_are_not_remembered() -> None:
    reader = ArrivalReader(Keys("main"))
    for number in range(10):
        assert reader.read(zenoh_inbox.Put(f"iw/v1/main/in/{'x' * 60_000}{number}/actions", b"{}", "")) is None
    assert reader.read(zenoh_inbox.Put("iw/v1/main/in/chair1/actions", b"{}", "")) == Put(
        "chair1", "actions", b"{}", ""
    )
    assert list(reader._known) == ["iw/v1/main/in/chair1/actions"]
