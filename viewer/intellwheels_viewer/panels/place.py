"""The palette of things to place, their heading, and turning and removing the selected body.

The position is chosen by a click in the scene. A body appears when the simulator has agreed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import viser

from intellwheels_viewer.panels.callbacks import chosen, clicked, disable, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block, note
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.steering import VIEW_ONLY

PALETTE: Final = {
    "Box": "crate",
    "Table": "table",
    "Person": "person",
    "Chair": "intellwheels",
}
"""Robots of `intellwheels_maps` that can be placed, by label."""
TURN_STEP: Final = 15
"""Step of the heading, in degrees."""


def place_html(snapshot: Snapshot, choices: Choices) -> str:
    """Return what the user can do next, or the reason why nothing can be placed."""
    if snapshot.phase != "live":
        words = note("No world is running", "wait")
    elif why := choices.rights.why_not_place(snapshot.world, choices.selected):
        words = note(f"{VIEW_ONLY}: {why}", "wait")
    elif choices.placing is not None:
        words = note(f"Click the floor to place the {choices.placing.lower()}. Press Escape to stop.", "good")
    else:
        words = note("Choose a thing to place, then click the floor. Drag a body to move it.")
    return block("place", words)


class PlacePanel:
    """The palette, the heading, turning and removing.

    Args:
        gui: Makes the elements, in the open container.
        on_choose: Called with the label of the thing to place, see `PALETTE`, or None to stop placing.
        on_turn: Called with the heading of placed bodies, in degrees, -180 to 180.
        on_turn_selected: Requests that the selected body turns on the spot by this many degrees.
        on_remove: Requests that the selected body is removed.
        on_undo: Requests that the newest change is undone.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        *,
        on_choose: Callable[[str | None], None],
        on_turn: Callable[[float], None],
        on_turn_selected: Callable[[float], None],
        on_remove: Callable[[], None],
        on_undo: Callable[[], None],
    ) -> None:
        gui.add_html(STYLE_SHEET)
        self._words = gui.add_html("")
        # Two rows of two: four buttons in a row do not fit.
        self._things = gui.add_button_group("Place a thing", tuple(PALETTE)[:2], disabled=True)
        self._bodies = gui.add_button_group("Place a body", tuple(PALETTE)[2:], disabled=True)
        self._turn = gui.add_slider("Heading, \u00b0", -180, 180, TURN_STEP, 0, marks=(), disabled=True)
        self._done = gui.add_button("Stop placing", icon=viser.Icon.X, color="gray", visible=False)
        self._by = gui.add_button_group("Turn, \u00b0", ("\u221290", "\u221215", "+15", "+90"), disabled=True)
        self._remove = gui.add_button("Remove", icon=viser.Icon.TRASH, color="red", disabled=True)
        self._undo = gui.add_button("Undo (Z)", icon=viser.Icon.ARROW_BACK_UP, color="gray", disabled=True)
        chosen(self._things, on_choose)
        clicked(self._undo, on_undo)
        chosen(self._bodies, on_choose)
        clicked(self._done, lambda: on_choose(None))
        clicked(self._remove, on_remove)
        chosen(self._by, lambda word: on_turn_selected(float(word.replace("\u2212", "-"))))
        updated(self._turn, lambda value: on_turn(float(min(max(value, -180), 180))))

    def show(self, snapshot: Snapshot, choices: Choices) -> None:
        """Show what can be done in a snapshot, and disable the rest."""
        live, world, rights = snapshot.phase == "live", snapshot.world, choices.rights
        enabled = live and not rights.why_not(world, "spawn")
        self._words.content = place_html(snapshot, choices)
        disable(self._things, not enabled)
        disable(self._bodies, not enabled)
        self._undo.disabled = not (live and choices.can_undo)
        self._done.visible = choices.placing is not None
        self._turn.disabled = not (enabled and choices.placing is not None)
        here = choices.selected is not None and snapshot.entity(choices.selected) is not None
        disable(self._by, not (live and here) or bool(rights.why_not(world, "teleport", choices.selected)))
        self._remove.disabled = not (live and here) or bool(rights.why_not(world, "delete", choices.selected))
        # The label of a button is plain text, so it needs no escaping.
        self._remove.label = f"Remove {choices.selected}" if here else "Remove"
