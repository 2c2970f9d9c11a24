"""A row of buttons of which one is active."""

from __future__ import annotations

import viser

from intellwheels_viewer.panels.segments import Segments
from tests.viewer.panels.panel import Calls, enter


def test_the_active_button_is_seen_and_a_press_calls(gui: viser.GuiApi, calls: Calls) -> None:
    row = Segments(gui, "Speed", ("1", "2"), calls.to("speed"))
    row.show("2")
    assert row._html.content.count('aria-pressed="true"') == 1
    assert 'data-choice="2" aria-pressed="true"' in row._html.content
    enter(row.pick._field, "1")
    assert calls == [("speed", "1")]


def test_what_is_not_on_offer_or_disabled_calls_nobody(gui: viser.GuiApi, calls: Calls) -> None:
    row = Segments(gui, "Speed", ("1", "2"), calls.to("speed"))
    enter(row.pick._field, "<script>")
    row.show("1", disabled=True)
    enter(row.pick._field, "2")
    assert calls == []
    assert row._html.content.count(" disabled>") == 2
