"""The palette."""

from __future__ import annotations

from dataclasses import replace

import pytest
import viser

from intellwheels_maps import library
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.place import PALETTE, PlacePanel, place_html
from tests.viewer.panels import made_up
from tests.viewer.panels.made_up import LOOKS_ONLY
from tests.viewer.panels.panel import Calls, enter, press


def panel(gui: viser.GuiApi, calls: Calls) -> PlacePanel:
    return PlacePanel(
        gui, on_choose=calls.to("choose"), on_turn=calls.to("turn"), on_turn_selected=calls.to("turn by"),
        on_remove=calls.to("remove"), on_undo=calls.to("undo"),
    )  # fmt: skip


@pytest.mark.parametrize("robot", PALETTE.values())
def test_what_can_be_placed_is_in_the_library(robot: str) -> None:
    assert library.robot(robot)


def test_what_to_do_next_is_said() -> None:
    snapshot = made_up.snapshot()
    assert "Choose a thing to place" in place_html(snapshot, Choices())
    assert "Click the floor to place the table" in place_html(snapshot, Choices(placing="Table"))
    assert "View only" in place_html(snapshot, Choices(rights=LOOKS_ONLY))
    assert "No world" in place_html(made_up.nothing("no-world"), Choices())


def test_words_of_a_peer_are_text() -> None:
    assert "<img" not in place_html(made_up.snapshot(), made_up.attacked())


def test_wishes_are_called(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    enter(shown._things, "Table")
    enter(shown._bodies, "Chair")
    press(shown._done)
    enter(shown._turn, 45)
    enter(shown._by, "\u221290")
    press(shown._remove)
    assert calls == [
        ("choose", "Table"), ("choose", "Chair"), ("choose", None), ("turn", 45.0), ("turn by", -90.0), ("remove",)
    ]  # fmt: skip


def test_a_turn_that_no_slider_has_is_bounded(gui: viser.GuiApi, calls: Calls) -> None:
    enter(panel(gui, calls)._turn, 10**9)
    assert calls == [("turn", 180.0)]


def test_what_cannot_act_is_disabled(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    shown.show(made_up.snapshot(), replace(made_up.choices(), placing="Table"))
    assert shown._done.visible
    assert not shown._turn.disabled
    assert (shown._remove.label, shown._remove.disabled) == ("Remove chair1", False)
    shown.show(made_up.snapshot(), Choices(selected="ghost"))
    assert (shown._remove.label, shown._remove.disabled) == ("Remove", True)
    shown.show(made_up.snapshot(), replace(made_up.choices(), rights=LOOKS_ONLY))
    assert shown._remove.disabled
    shown.show(made_up.snapshot(), replace(made_up.choices(), rights=made_up.DENIED))
    assert shown._remove.disabled
    assert "guest may not ask for ctl/spawn in world main" in shown._words.content
