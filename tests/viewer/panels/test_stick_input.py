"""The script of the keys and the stick, as far as it goes without a page; `test_page` presses them."""

from __future__ import annotations

import viser

from intellwheels_viewer.panels.stick_input import StickInput, script_html
from tests.viewer.panels.panel import Calls, enter


def test_the_handler_stays_in_its_attribute() -> None:
    handler = script_html("some-id").split('onerror="')[1].split('"')[0]
    assert "some-id" in handler
    assert handler.endswith("})()\n")


def test_the_page_sends_only_while_it_is_enabled(gui: viser.GuiApi) -> None:
    stick = StickInput(gui)
    assert "iw-drive-off" in stick._off.content
    stick.enable(True)
    assert stick._off.content == ""
    stick.enable(False)
    assert "iw-drive-off" in stick._off.content


def test_each_message_is_heard_until_the_elements_are_removed(gui: viser.GuiApi, calls: Calls) -> None:
    stick = StickInput(gui)
    stick.listen(calls.to("stick"))
    enter(stick.value, (0.5, -0.25, 1.0))
    assert calls == [("stick", (0.5, -0.25, 1.0))]
    stick.remove()
