"""The palette: what may be put on the floor, how it is turned, and taking the selected body away.

A press here is a wish only. Where it will stand is chosen in the scene; it stands when the state says so.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import viser

from intellwheels_viewer.panels.callbacks import chosen, clicked, disable, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block, note
from intellwheels_viewer.snapshot import Snapshot

PALETTE: Final = {
    "Box": "crate",
    "Table": "table",
    "Person": "person",
    "Chair": "intellwheels",
}
"""What can be placed, by label: the name of a robot in `intellwheels_maps`."""
TURN_STEP: Final = 15
"""Degrees of a step of the turn."""


def place_html(seen: Snapshot, choices: Choices) -> str:
    """Return what to do next, or why there is nothing to do."""
    if seen.phase != "live":
        words = note("No world to place anything in", "wait")
    elif not choices.allowed:
        words = note("You may look, not place: this viewer has no right to control", "wait")
    elif choices.placing is not None:
        words = note(f"Click the floor where the {choices.placing.lower()} shall stand", "good")
    else:
        words = note("Choose what to place, then click the floor. Drag a body to move it.")
    return block("place", words)


class PlacePanel:
    """The palette, the turn, and remove.

    Args:
        gui: Where the elements are made, in the container that is open.
        on_choose: Gets the label of what the next click places, see `PALETTE`; None when no click places any more.
        on_turn: Gets the heading for what is placed, in degrees, -180 to 180.
        on_turn_selected: Asks that the selected body be turned on the spot by so many degrees.
        on_remove: Asks that the selected body be taken out.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        *,
        on_choose: Callable[[str | None], None],
        on_turn: Callable[[float], None],
        on_turn_selected: Callable[[float], None],
        on_remove: Callable[[], None],
    ) -> None:
        gui.add_html(STYLE_SHEET)
        self._words = gui.add_html("")
        # Two by two: four in a row are wider than a panel of 280 px.
        self._things = gui.add_button_group("Place a thing", tuple(PALETTE)[:2], disabled=True)
        self._bodies = gui.add_button_group("Place a body", tuple(PALETTE)[2:], disabled=True)
        self._turn = gui.add_slider("Heading, \u00b0", -180, 180, TURN_STEP, 0, marks=(), disabled=True)
        self._done = gui.add_button("Stop placing", icon=viser.Icon.X, color="gray", visible=False)
        self._by = gui.add_button_group("Turn, \u00b0", ("\u221290", "\u221215", "+15", "+90"), disabled=True)
        self._remove = gui.add_button("Remove", icon=viser.Icon.TRASH, color="red", disabled=True)
        chosen(self._things, on_choose)
        chosen(self._bodies, on_choose)
        clicked(self._done, lambda: on_choose(None))
        clicked(self._remove, on_remove)
        chosen(self._by, lambda word: on_turn_selected(float(word.replace("\u2212", "-"))))
        updated(self._turn, lambda value: on_turn(float(min(max(value, -180), 180))))

    def show(self, seen: Snapshot, choices: Choices) -> None:
        """Show what can be done now."""
        able = seen.phase == "live" and choices.allowed
        self._words.content = place_html(seen, choices)
        disable(self._things, not able)
        disable(self._bodies, not able)
        self._done.visible = choices.placing is not None
        self._turn.disabled = not (able and choices.placing is not None)
        here = choices.selected is not None and seen.entity(choices.selected) is not None
        disable(self._by, not (able and here))
        self._remove.disabled = not (able and here)
        # A button's label is text: markup in it is inert.
        self._remove.label = f"Remove {choices.selected}" if here else "Remove"
