"""The script of the page's keys, as far as it goes without a page; `test_page` presses them."""

from __future__ import annotations

import html

import viser

from intellwheels_viewer.panels.page_keys import PageKeys


def test_the_handler_is_one_attribute_that_nothing_leaves(gui: viser.GuiApi) -> None:
    inner = PageKeys(gui)._script.content.partition('onerror="')[2]
    assert inner.endswith('">')
    assert '"' not in inner[:-2]
    assert "<" not in inner[:-2]
    assert html.unescape(inner[:-2]).strip().endswith("})()")
