"""From a page's messages to plain callables."""

from __future__ import annotations

import inspect
from typing import Any, cast

import viser

from intellwheels_viewer.panels.callbacks import Pick, assign, chosen, clicked, disable, element_id, updated
from tests.viewer.panels.panel import Calls, enter, press


def test_a_click_calls(gui: viser.GuiApi, calls: Calls) -> None:
    button = gui.add_button("Go")
    clicked(button, calls.to("go"))
    press(button)
    assert calls == [("go",)]


def test_a_value_of_a_page_calls_and_our_own_does_not(gui: viser.GuiApi, calls: Calls) -> None:
    text = gui.add_text("Text", "")
    updated(text, calls.to("text"))
    assign(text, "ours")
    enter(text, "theirs")
    assert text.value == "theirs"
    assert calls == [("text", "theirs")]


def test_callbacks_run_in_the_loop_where_order_holds(gui: viser.GuiApi, calls: Calls) -> None:
    button, text = gui.add_button("Go"), gui.add_text("Text", "")
    clicked(button, calls.to("go"))
    updated(text, calls.to("text"))
    registered = [*button._impl.update_cb, *text._impl.update_cb]
    assert len(registered) == 2
    assert all(inspect.iscoroutinefunction(call) for call in registered)


def test_a_button_that_no_group_has_calls_nobody(gui: viser.GuiApi, calls: Calls) -> None:
    group = gui.add_button_group("Speed", ("1", "2"))
    chosen(group, calls.to("speed"))
    enter(group, "99")
    enter(group, "2")
    assert calls == [("speed", "2")]


def test_a_group_is_disabled_and_enabled(gui: viser.GuiApi) -> None:
    group = gui.add_button_group("Speed", ("1", "2"))
    disable(group, True)
    assert cast("Any", group)._impl.props.disabled
    disable(group, False)
    assert not cast("Any", group)._impl.props.disabled


def test_the_same_row_can_be_picked_twice(gui: viser.GuiApi, calls: Calls) -> None:
    pick = Pick(gui, calls.to("pick"))
    for _ in range(2):
        enter(pick._field, "chair1")
        assert pick._field.value == ""
    assert calls == [("pick", "chair1"), ("pick", "chair1")]


def test_the_handler_of_a_pick_names_its_field_and_stays_in_its_attribute(gui: viser.GuiApi) -> None:
    pick = Pick(gui, print)
    assert element_id(pick._field) in pick.attribute
    assert pick.attribute.count('"') == 2
    button = Pick(gui, print, "choice")
    assert "onclick=" in button.attribute
    assert "dataset.choice" in button.attribute
    assert button.attribute.count('"') == 2
