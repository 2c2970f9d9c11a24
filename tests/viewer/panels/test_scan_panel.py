"""Scanning on a page, from messages as a page would send them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
import viser

from intellwheels_schemas.switch_scan import ScanSettings, ScanView
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.scan_panel import OFF, ScanPanel, board_html
from intellwheels_viewer.panels.stick_input import GENTLE
from tests.viewer.panels import made_up
from tests.viewer.panels.panel import Calls, enter


class Page:
    """A page that sends ten messages a second."""

    def __init__(self, gui: viser.GuiApi, calls: Calls, method: str) -> None:
        self.time = 100.0
        self.calls = calls
        self.panel = ScanPanel(gui, on_stick=calls.to("stick"), now=lambda: self.time)
        self.panel.show(made_up.snapshot(), made_up.choices())
        enter(self.panel.method, method)
        self.sends(0.1)

    def sends(self, seconds: float, switches: int = 0, cell: int = 0) -> None:
        for _ in range(round(seconds * 10.0)):
            self.time += 0.1
            enter(self.panel.message, (float(switches), float(cell), self.time))

    @property
    def board(self) -> str:
        return self.panel._board.content

    def drives(self) -> list[tuple[float, float]]:
        """Return forward and turn of all calls, without repetitions."""
        found: list[tuple[float, float]] = []
        for _, forward, turn, _count in self.calls:
            if found[-1:] != [(forward, turn)]:
                found.append((forward, turn))
        return found


def test_one_switch_drives_the_highlighted_way_while_it_is_held(gui: viser.GuiApi, calls: Calls) -> None:
    page = Page(gui, calls, "One switch")
    page.sends(3.0)
    assert calls == []
    while 'lit" data-scan="2"' not in page.board:
        page.sends(0.1)
    page.sends(1.0, switches=1)
    assert 'driving" data-scan="2"' in page.board
    page.sends(0.5)
    assert page.drives() == [(0.0, GENTLE), (0.0, 0.0)]
    # Once per message, and one release.
    assert len(calls) == 11


def test_two_switches_move_and_select(gui: viser.GuiApi, calls: Calls) -> None:
    page = Page(gui, calls, "Two switches")
    for _ in range(3):
        page.sends(0.1, switches=1)
        page.sends(0.1)
    page.sends(0.5, switches=2)
    page.sends(0.1)
    assert page.drives() == [(-GENTLE, 0.0), (0.0, 0.0)]


def test_a_resting_pointer_drives_until_it_leaves(gui: viser.GuiApi, calls: Calls) -> None:
    page = Page(gui, calls, "Dwell")
    enter(page.panel.seconds, 0.5)
    page.sends(0.4, cell=1)
    assert "animation-duration:0.5s" in page.board
    assert calls == []
    page.sends(1.0, cell=1)
    page.sends(1.0)
    assert page.drives() == [(GENTLE, 0.0), (0.0, 0.0)]


def test_a_page_that_hangs_drives_no_more(gui: viser.GuiApi, calls: Calls) -> None:
    page = Page(gui, calls, "One switch")
    page.sends(0.5, switches=1)
    number = len(calls)
    page.time += 5.0
    # Nothing came, nothing went out; and the switch that is still down selects nothing.
    assert len(calls) == number
    page.sends(1.0, switches=1)
    assert page.drives() == [(GENTLE, 0.0), (0.0, 0.0)]


def test_another_selection_or_setting_ends_driving(gui: viser.GuiApi, calls: Calls) -> None:
    page = Page(gui, calls, "One switch")
    page.sends(0.5, switches=1)
    page.panel.show(made_up.snapshot(), replace(made_up.choices(), selected="chair2"))
    page.sends(0.5, switches=1)
    assert page.drives() == [(GENTLE, 0.0), (0.0, 0.0)]
    page.sends(0.1)
    page.sends(0.3, switches=1)
    enter(page.panel.confirm, True)
    page.sends(0.3, switches=1)
    assert page.drives()[-1] == (0.0, 0.0)
    page.sends(0.1)
    page.sends(0.2, switches=1)
    assert 'armed" data-scan="1"' in page.board
    assert "Select twice to confirm" in page.board


@pytest.mark.parametrize(
    "choices", [Choices(), Choices(selected="table1"), Choices(selected="chair1", rights=made_up.DENIED)]
)
def test_nothing_is_driven_or_shown_when_nothing_can_be(gui: viser.GuiApi, calls: Calls, choices: Choices) -> None:
    page = Page(gui, calls, "One switch")
    assert 'id="iw-scan"' in page.board
    page.panel.show(made_up.snapshot(), choices)
    page.sends(0.1)
    page.sends(0.5, switches=1)
    assert page.board == ""
    assert calls == []


def test_off_is_off(gui: viser.GuiApi, calls: Calls) -> None:
    page = Page(gui, calls, OFF)
    page.sends(1.0, switches=1)
    assert (page.board, list(calls)) == ("", [])
    assert not page.panel.seconds.visible


@pytest.mark.parametrize(
    "value", [(), (1.0,), (math.nan, 0.0, 0.0), (1.0, 99.0, 0.0), (4.0, 0.0, 0.0), (1.0, 0.5, 0.0)]
)
def test_a_message_that_no_page_sends_is_dropped(gui: viser.GuiApi, calls: Calls, value: Any) -> None:
    page = Page(gui, calls, "One switch")
    enter(page.panel.message, value)
    assert calls == []


@pytest.mark.parametrize("seconds", [math.nan, 1e9, -1.0])
def test_seconds_of_a_page_are_bounded(gui: viser.GuiApi, calls: Calls, seconds: float) -> None:
    page = Page(gui, calls, "One switch")
    enter(page.panel.seconds, seconds)
    assert 0.2 <= page.panel._scan.settings.period <= 10.0


def test_the_board_has_every_command_once() -> None:
    board = board_html(ScanView(), ScanSettings())
    assert [board.count(f'data-scan="{number}"') for number in range(1, 6)] == [1] * 5
