"""Driving by hand, as far as it goes without a page."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import viser

from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.drive_panel import (
    EVERYBODY,
    SAY_LIMIT,
    DrivePanel,
    can_drive,
    drive_html,
)
from intellwheels_viewer.panels.stick_input import GENTLE, StickInput
from tests.viewer.panels import made_up
from tests.viewer.panels.made_up import LOOKS_ONLY
from tests.viewer.panels.panel import Calls, enter, hold, press


def panel(gui: viser.GuiApi, calls: Calls, choices: Choices | None = None) -> DrivePanel:
    shown = DrivePanel(gui, StickInput(gui), on_stick=calls.to("stick"), on_say=calls.to("say"))
    shown.show(made_up.snapshot(), choices or made_up.choices())
    return shown


def test_who_is_driven_or_why_nobody_is_said() -> None:
    snapshot = made_up.snapshot()
    driving = replace(made_up.choices(), driven="chair1")
    assert "You are driving chair1" in drive_html(snapshot, driving)
    for driven in (None, "chair2"):
        idle = drive_html(snapshot, replace(made_up.choices(), driven=driven))
        assert "Hold the stick or the keys W A S D to drive chair1." in idle
        assert "You are driving" not in idle
    over = drive_html(replace(snapshot, clock=made_up.clock("ended")), driving)
    assert "The run is over. Run it again to drive chair1." in over
    assert "You are driving" not in over
    assert "Nothing is selected" in drive_html(snapshot, Choices())
    assert "table1 has no motors" in drive_html(snapshot, Choices(selected="table1"))
    assert "View only" in drive_html(snapshot, Choices(selected="chair1", rights=LOOKS_ONLY))
    assert "guest may not write user/chair1" in drive_html(snapshot, Choices(selected="chair1", rights=made_up.DENIED))
    own = drive_html(snapshot, Choices(selected="chair2", rights=made_up.DENIED))
    assert "Hold the stick" in own
    assert "guest may not ask for ctl/say in world main" in own
    assert "No world" in drive_html(made_up.nothing("no-world"), Choices())


def test_the_page_sends_nothing_while_nobody_can_be_driven(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    assert shown._stick._off.content == ""
    for choices in (Choices(), Choices(selected="table1"), Choices(selected="chair1", rights=LOOKS_ONLY)):
        shown.show(made_up.snapshot(), choices)
        assert "iw-drive-off" in shown._stick._off.content
        assert not can_drive(made_up.snapshot(), choices)


def test_words_of_a_peer_are_text() -> None:
    assert "<img" not in drive_html(made_up.hostile(), made_up.attacked())


def test_each_message_is_passed_on_once_with_a_growing_count(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    enter(shown._stick.value, (0.5, -0.25, 1.0))
    enter(shown._stick.value, (0.5, -0.25, 2.0))
    shown.show(made_up.snapshot(), made_up.choices())
    enter(shown._stick.value, (0.0, 0.0, 3.0))
    assert calls == [("stick", 0.5, -0.25, 1), ("stick", 0.5, -0.25, 2), ("stick", 0.0, 0.0, 3)]


@pytest.mark.parametrize("value", [(math.nan, 0.0, 1.0), (0.0, math.inf, 1.0), (1.0, 1.0), ()])
def test_a_message_that_no_stick_sends_is_dropped(gui: viser.GuiApi, calls: Calls, value: tuple[float, ...]) -> None:
    enter(panel(gui, calls)._stick.value, value)
    assert calls == []


def test_power_is_bounded(gui: viser.GuiApi, calls: Calls) -> None:
    enter(panel(gui, calls)._stick.value, (99.0, -99.0, 1.0))
    assert calls == [("stick", 1.0, -1.0, 1)]


def test_nobody_is_driven_without_rights_whatever_a_page_sends(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls, replace(made_up.choices(), rights=LOOKS_ONLY))
    enter(shown._stick.value, (1.0, 0.0, 1.0))
    for button in shown._buttons:
        assert button.disabled
        hold(button)
    assert calls == []


def test_held_buttons_drive_each_its_way(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    for button in shown._buttons:
        hold(button)
    assert [(forward, turn) for _, forward, turn, _ in calls] == [
        (GENTLE, 0.0), (0.0, GENTLE), (0.0, -GENTLE), (-GENTLE, 0.0)
    ]  # fmt: skip


def test_buttons_are_there_when_wanted(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    assert not any(button.visible for button in shown._buttons)
    enter(shown._wanted, True)
    assert all(button.visible for button in shown._buttons)


def test_words_go_to_everybody_or_to_the_selected_one(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    enter(shown._text, "  make way ")
    press(shown._say)
    assert shown._text.value == ""
    press(shown._say)
    enter(shown._text, "you")
    enter(shown._to, "chair1")
    press(shown._say)
    assert calls == [("say", "make way", None), ("say", "you", "chair1")]


def test_words_meant_for_one_do_not_go_to_the_next_selected(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    enter(shown._to, "chair1")
    shown.show(made_up.snapshot(), replace(made_up.choices(), selected="chair2"))
    assert shown._to.options == (EVERYBODY, "chair2")
    assert shown._to.value == EVERYBODY


def test_words_longer_than_the_wire_takes_are_cut(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    enter(shown._text, "a" * 5000)
    press(shown._say)
    assert len(calls[0][1]) == SAY_LIMIT


def test_a_key_held_while_another_is_selected_does_not_drive_that_one(gui: viser.GuiApi, calls: Calls) -> None:
    shown = panel(gui, calls)
    enter(shown._stick.value, (1.0, 0.0, 1.0))
    shown.show(made_up.snapshot(), replace(made_up.choices(), selected="chair2"))
    enter(shown._stick.value, (1.0, 0.0, 2.0))
    enter(shown._stick.value, (0.0, 0.0, 3.0))
    assert calls == [("stick", 1.0, 0.0, 1)]
    enter(shown._stick.value, (0.0, 1.0, 4.0))
    assert calls == [("stick", 1.0, 0.0, 1), ("stick", 0.0, 1.0, 2)]
