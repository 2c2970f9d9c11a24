"""Notices: a refusal that repeats is shown once, anything else each time."""

from __future__ import annotations

from typing import Any, cast

import pytest

from intellwheels_viewer.page_notices import REFUSED, PageNotices


class _Client:
    def __init__(self) -> None:
        self.shown: list[tuple[str, str, str | None]] = []

    def add_notification(self, title: str, text: str, *, color: str | None = None, **_: Any) -> None:
        self.shown.append((title, text, color))


def test_a_refusal_is_shown_once_until_it_has_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr("intellwheels_viewer.page_notices.time.monotonic", lambda: now)
    client = _Client()
    notices = PageNotices(cast("Any", client))
    for _ in range(3):
        notices.refused("Not moved", "a wall")
    notices.refused("Not moved", "a door")
    notices.refused("Not moved", "a wall")
    now += REFUSED
    notices.refused("Not moved", "a wall")
    notices.tell("Saved", "a page")
    notices.tell("Saved", "a page")
    reasons = ["a wall", "a door", "a wall", "a wall"]
    assert client.shown == [("Not moved", why, "red") for why in reasons] + 2 * [("Saved", "a page", None)]
