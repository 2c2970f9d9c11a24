"""The tabs Drive and Place of one page. A playback cannot be controlled, so it does not have them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import viser

from intellwheels_viewer.goal_click import takes_goals
from intellwheels_viewer.panels.callbacks import clicked
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.drive_panel import DrivePanel
from intellwheels_viewer.panels.place import PlacePanel
from intellwheels_viewer.panels.scan_panel import ScanPanel
from intellwheels_viewer.panels.stick_input import StickInput

if TYPE_CHECKING:
    from intellwheels_viewer.snapshot import Snapshot


@dataclass(frozen=True)
class ControlCalls:
    """The callbacks of the controls; see `DrivePanel` and `PlacePanel`."""

    stick: Callable[[float, float, int], None]
    say: Callable[[str, str | None], None]
    aim: Callable[[], None]
    choose: Callable[[str | None], None]
    turn: Callable[[float], None]
    turn_selected: Callable[[float], None]
    remove: Callable[[], None]
    undo: Callable[[], None]


@dataclass(frozen=True)
class _Parts:
    stick: StickInput
    drive: DrivePanel
    scan: ScanPanel
    goal: viser.GuiButtonHandle
    place: PlacePanel
    tabs: tuple[viser.GuiTabHandle, ...]


class ControlTabs:
    """The tabs, made while there is a live run.

    Args:
        gui: Makes the elements.
        group: Where the tabs are.
        calls: What the controls call.
    """

    def __init__(self, gui: viser.GuiApi, group: viser.GuiTabGroupHandle, calls: ControlCalls) -> None:
        self._gui, self._group, self._calls = gui, group, calls
        self._parts: _Parts | None = self._make()

    @property
    def are_there(self) -> bool:
        """Whether the page has the tabs."""
        return self._parts is not None

    def show(self, snapshot: Snapshot, choices: Choices) -> None:
        """Show what can be controlled; without tabs in a playback, and for a browser that may only look."""
        if (snapshot.last_tick is None and not choices.rights.looks_only) != self.are_there:
            if self._parts is None:
                self._parts = self._make()
            else:
                for tab in self._parts.tabs:
                    tab.remove()
                self._parts.stick.remove()
                self._parts = None
        if self._parts is not None:
            self._parts.drive.show(snapshot, choices)
            self._parts.scan.show(snapshot, choices)
            self._parts.place.show(snapshot, choices)
            self._parts.goal.visible = takes_goals(snapshot, choices.selected)
            self._parts.goal.disabled = bool(choices.rights.why_not_drive(snapshot.world, choices.selected))

    def _make(self) -> _Parts:
        gui, calls = self._gui, self._calls
        stick = StickInput(gui)
        drive_tab = self._group.add_tab("Drive")
        with drive_tab:
            drive = DrivePanel(gui, stick, on_stick=calls.stick, on_say=calls.say)
            scan = ScanPanel(gui, on_stick=calls.stick)
            goal = gui.add_button("Set a goal", icon=viser.Icon.FLAG, color="gray", visible=False)
            clicked(goal, calls.aim)
        place_tab = self._group.add_tab("Place")
        with place_tab:
            place = PlacePanel(
                gui,
                on_choose=calls.choose,
                on_turn=calls.turn,
                on_turn_selected=calls.turn_selected,
                on_remove=calls.remove,
                on_undo=calls.undo,
            )
        return _Parts(stick, drive, scan, goal, place, (drive_tab, place_tab))
