"""A row of buttons of which one is active, in HTML: viser's button group does not show which of its buttons is."""

from __future__ import annotations

import html
from collections.abc import Callable, Sequence

import viser

from intellwheels_viewer.panels.callbacks import Pick


def segments_html(label: str, options: Sequence[str], active: str | None, handler: str, *, disabled: bool) -> str:
    """Return the row.

    Args:
        label: What is chosen.
        options: The texts of the buttons.
        active: The active one, or None.
        handler: An HTML attribute of the row that takes presses of its `data-choice` buttons.
        disabled: Whether nothing can be chosen.
    """
    off = " disabled" if disabled else ""
    buttons = "".join(
        f'<button type="button" data-choice="{html.escape(option)}" '
        f'aria-pressed="{"true" if option == active else "false"}"{off}>{html.escape(option)}</button>'
        for option in options
    )
    name = html.escape(label)
    return (
        f'<div class="iw iw-choice"><span>{name}</span>'
        f'<div class="iw-segments" role="group" aria-label="{name}" {handler}>{buttons}</div></div>'
    )


class Segments:
    """The row of one panel.

    Args:
        gui: Makes the elements, in the open container.
        label: What is chosen.
        options: The texts of the buttons.
        call: Called with the text of a pressed button.
    """

    def __init__(self, gui: viser.GuiApi, label: str, options: Sequence[str], call: Callable[[str], None]) -> None:
        self._label, self._options, self._call = label, tuple(options), call
        self.pick = Pick(gui, self._picked, "choice")
        self._html = gui.add_html("")
        self.disabled = False
        self.active: str | None = None
        self.show(None)

    @property
    def visible(self) -> bool:
        """Whether the page has the row."""
        return bool(self._html.visible)

    def show(self, active: str | None, *, visible: bool = True, disabled: bool = False) -> None:
        """Show which button is active, and whether there is a choice."""
        self.active, self.disabled = active, disabled
        self._html.visible = visible
        self._html.content = segments_html(self._label, self._options, active, self.pick.attribute, disabled=disabled)

    def _picked(self, option: str) -> None:
        if option in self._options and not self.disabled:
            self._call(option)
