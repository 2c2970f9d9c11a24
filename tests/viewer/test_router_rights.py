"""The viewer asks the router for its rights, again when they may have changed."""

from __future__ import annotations

import threading
from typing import Any, cast

import pytest

from intellwheels_schemas.messages import Identity
from intellwheels_viewer import router_rights
from tests.viewer.wire import until


def test_rights_are_asked_for_once_and_again_in_doubt(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []
    goes_on = threading.Event()

    def own_rights(session: object) -> Identity:
        asked.append(session)
        goes_on.wait(20.0)
        return Identity(name=f"a{len(asked)}")

    monkeypatch.setattr(router_rights, "own_rights", own_rights)
    rights, session = router_rights.RouterRights(), cast(Any, "session")
    rights.refresh(session)
    rights.doubt()
    rights.refresh(session)  # one at a time
    assert asked == ["session"]
    goes_on.set()
    until(lambda: rights.identity == Identity(name="a1") and not rights._asks)
    rights.refresh(session)
    until(lambda: rights.identity == Identity(name="a2"))
    rights.refresh(session)
    assert len(asked) == 2
