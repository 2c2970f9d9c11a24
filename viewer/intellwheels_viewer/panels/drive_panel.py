"""Driving with a stick on the screen or with keys, see `stick_input`; and sending messages to agents.

`stick_input` sends what the stick and the keys give. The receiver publishes each message once and repeats none, so a
page that is closed or hangs stops the chair. Four buttons work without the script of `stick_input`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import viser

from intellwheels_viewer.panels.callbacks import assign, clicked, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.stick_input import GENTLE, RATE, StickInput
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block, note, prose
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.steering import VIEW_ONLY

EVERYBODY: Final = "Everybody"
SAY_LIMIT: Final = 1000
"""Characters: the limit of the contract. A simulation can have a lower one, and its refusal is shown."""

_STICK: Final = (
    '<div class="iw-drive"><div class="iw-stick" id="iw-stick" data-testid="stick" role="img" '
    'aria-label="Stick: drag to drive"><u style="left:50px;top:3px">W</u><u style="left:50px;bottom:3px">S</u>'
    '<u style="left:4px;top:50px">A</u><u style="right:4px;top:50px">D</u>'
    '<div class="iw-knob" id="iw-knob"></div></div>'
    "<div>Drag the stick, or hold<br><code>W</code> forward<br><code>S</code> back<br><code>A</code> <code>D</code> "
    'turn<div class="iw-small">Shift for full power. Release to stop.</div></div></div>'
    '<div id="iw-no-keys" class="iw-small" hidden>Keys and stick do not work in this browser: tick Buttons.</div>'
    """<img src="x:" alt="" style="display:none" """
    """onerror="document.getElementById('iw-no-keys').hidden=Boolean(window.__viserMutable)">"""
)


def drive_html(snapshot: Snapshot, choices: Choices) -> str:
    """Return the agent that is driven, or how to drive the selected one, or why it cannot be driven."""
    if snapshot.phase != "live":
        words = note("No world is running", "wait")
    elif why := choices.rights.why_not_drive(snapshot.world, choices.selected):
        words = note(f"{VIEW_ONLY}: {why}", "wait")
    elif choices.selected is None:
        words = note("Nothing is selected. Click a chair.")
    elif not can_drive(snapshot, choices):
        words = note(f"{choices.selected} has no motors", "wait")
    elif snapshot.is_over:
        words = note(f"The run is over. Run it again to drive {choices.selected}.", "wait")
    elif choices.driven == choices.selected:
        words = note(f"You are driving {choices.selected}", "good")
    else:
        words = note(f"Hold the stick or the keys W A S D to drive {choices.selected}.")
    if snapshot.phase == "live" and (unsaid := choices.rights.why_not(snapshot.world, "say")):
        words += f'<div class="iw-small">{prose(unsaid)}</div>'
    return block("drive", words)


def can_drive(snapshot: Snapshot, choices: Choices) -> bool:
    """Return whether the selected body can be driven from this page."""
    if snapshot.phase != "live" or choices.selected is None:
        return False
    if choices.rights.why_not_drive(snapshot.world, choices.selected):
        return False
    body = snapshot.bodies.get(choices.selected)
    return body is not None and snapshot.entity(choices.selected) is not None and body.robot.top_speed > 0


def stick_html() -> str:
    """Return the stick. Written once: rewriting it would release a stick that is in use."""
    return block("stick-area", _STICK)


class DrivePanel:
    """Stick, keys, buttons and the message form.

    Args:
        gui: Makes the elements, in the open container.
        stick: The input of the stick and the keys, which is made outside the tab of this panel.
        on_stick: Called with forward and turn (positive to the left), each in [-1, 1], and a message count. Once per
            message of the page; 0, 0 is a release.
        on_say: Called with a text, not empty, and its receiver: an agent's name, or None for everybody.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        stick: StickInput,
        *,
        on_stick: Callable[[float, float, int], None],
        on_say: Callable[[str, str | None], None],
    ) -> None:
        gui.add_html(STYLE_SHEET)
        self._words = gui.add_html("")
        self._stick_html = gui.add_html(stick_html())
        self._stick = stick
        self._on_stick, self._on_say = on_stick, on_say
        self._selected: str | None = None
        self._count = 0
        self._able = self._drag_move = self._blocked = False
        stick.listen(self._pulled)
        self._wanted = gui.add_checkbox(
            "Buttons", False, hint="Show four buttons to hold, for browsers in which keys and stick do not work"
        )
        self._buttons = [
            self._hold(gui.add_button(label, icon=icon, color="gray", visible=False), forward, turn)
            for label, icon, forward, turn in (
                ("Forward", viser.Icon.ARROW_UP, GENTLE, 0.0),
                ("Left", viser.Icon.ARROW_LEFT, 0.0, GENTLE),
                ("Right", viser.Icon.ARROW_RIGHT, 0.0, -GENTLE),
                ("Back", viser.Icon.ARROW_DOWN, -GENTLE, 0.0),
            )
        ]
        updated(self._wanted, self._reveal)
        with gui.add_form(None) as form:
            self._text = gui.add_text("Say", "", disabled=True)
            self._to: viser.GuiDropdownHandle[str] = gui.add_dropdown("To", (EVERYBODY,), disabled=True)
            self._say = gui.add_button("Say it", icon=viser.Icon.MESSAGE, color="gray", disabled=True)
        clicked(self._say, self._said)
        form.on_submit(self._submitted)

    def show(self, snapshot: Snapshot, choices: Choices) -> None:
        """Show which agent is driven. The stick itself is not rewritten."""
        self._words.content = drive_html(snapshot, choices)
        if choices.selected != self._selected:
            # A key that is still down drove the previous agent. It must be released before it drives the next one.
            self._blocked = self._drag_move
        self._able, self._selected = can_drive(snapshot, choices), choices.selected
        self._stick.enable(self._able)
        for button in self._buttons:
            button.disabled = not self._able
        may_say = snapshot.phase == "live" and not choices.rights.why_not(snapshot.world, "say")
        self._text.disabled = self._to.disabled = self._say.disabled = not may_say
        to = (EVERYBODY,) if choices.selected is None else (EVERYBODY, choices.selected)
        if to != self._to.options:
            # The selection changed: a message meant for the previous agent must not go to the new one.
            self._to.options = to
            assign(self._to, EVERYBODY)

    def _pulled(self, value: tuple[float, float, float]) -> None:
        if len(value) != 3:
            return
        self._drag_move = bool(value[0] or value[1])
        blocked, self._blocked = self._blocked, self._blocked and self._drag_move
        if not blocked:
            self._put(value[0], value[1])

    def _hold(self, button: viser.GuiButtonHandle, forward: float, turn: float) -> viser.GuiButtonHandle:
        async def hold(_: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
            self._put(forward, turn)

        button.on_hold(hold, callback_hz=RATE)
        return button

    def _put(self, forward: float, turn: float) -> None:
        if not self._able or not (math.isfinite(forward) and math.isfinite(turn)):
            return
        self._count += 1
        self._on_stick(min(max(forward, -1.0), 1.0), min(max(turn, -1.0), 1.0), self._count)

    def _reveal(self, wanted: bool) -> None:
        for button in self._buttons:
            button.visible = bool(wanted)

    async def _submitted(self, _: viser.GuiEvent[viser.GuiFormHandle]) -> None:
        self._said()

    def _said(self) -> None:
        text = self._text.value.strip()[:SAY_LIMIT]
        if text:
            self._on_say(text, self._selected if self._to.value == self._selected else None)
            assign(self._text, "")
