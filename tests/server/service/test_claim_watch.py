from __future__ import annotations

import threading
from contextlib import closing

import pytest

from intellwheels_schemas import link
from intellwheels_schemas.keys import Keys
from intellwheels_server.service.claim_watch import ClaimWatch, WorldTakenError
from tests.e2e.stage import free_port


@pytest.mark.process
def test_second_claim_of_a_world_gives_way_and_another_world_is_free() -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    first = link.open_session(link.Link(listen=(endpoint,)), threading.Event())
    second = link.open_session(link.Link(connect=(endpoint,)), threading.Event())
    assert first is not None
    assert second is not None
    with first, second, closing(ClaimWatch(first, Keys("main"))) as held:
        held.begin()
        with pytest.raises(WorldTakenError, match="world 'main'"):
            ClaimWatch(second, Keys("main"))
        ClaimWatch(second, Keys("other")).close()
        held.check()
