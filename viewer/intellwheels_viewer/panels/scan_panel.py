"""Driving with one or two switches, or with a pointer that rests, such as that of an eye tracker.

The page sends ten times a second which switches are down and over which command the pointer is, while the board is
shown, the page has the focus and is visible. The scan runs here, only when such a message comes, and publishes nothing
else: a page that is closed or hangs stops the chair. A press counts for at least `TAP` ms, because viser sends only the
newest of the messages of 50 ms. A finger that is lifted rests nowhere. The script uses a private name of viser (see
callbacks).
"""

from __future__ import annotations

import html
import math
import time
from collections.abc import Callable
from typing import Final

import viser

from intellwheels_schemas.switch_scan import COMMANDS, Method, ScanSettings, ScanView, SwitchScan
from intellwheels_viewer.panels.callbacks import element_id, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.drive_panel import can_drive
from intellwheels_viewer.panels.stick_input import GENTLE, RATE
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block
from intellwheels_viewer.snapshot import Snapshot

OFF: Final = "Off"
METHOD_LABELS: Final[dict[str, Method]] = {"One switch": "auto", "Two switches": "step", "Dwell": "dwell"}
"""The methods by label."""
SHORTEST, LONGEST = 0.2, 10.0
"""Shortest and longest scan period and dwell, in seconds."""
_CELLS: Final = (None, "forward", None, "left", "stop", "right", None, "back", None)
_NAMES: Final = tuple(COMMANDS)
_HINTS: Final[dict[Method, str]] = {
    "auto": "Hold <code>Space</code> to drive the highlighted way.",
    "step": "<code>Space</code> moves the highlight. Hold <code>Enter</code> to drive.",
    "dwell": f"Rest the pointer on a command to drive, for at most {ScanSettings().hold:g} s. Leave it to stop.",
}
_SCRIPT: Final = """
(() => {
const W = window, D = document, KEYS = {Space: 1, Enter: 2}, TAP = 120, since = {}, ups = {};
if (W.__iwScan) W.__iwScan.abort();
const stop = W.__iwScan = new AbortController();
let down = 0, x = -1, y = -1, n = 0, live = false;
const board = () => D.getElementById('iw-scan');
const over = () => {
  const at = x < 0 ? null : D.elementFromPoint(x, y), cell = at && at.closest('[data-scan]');
  return cell ? Number(cell.dataset.scan) : 0;
};
const send = (switches, cell) => W.__viserMutable.sendMessage(
  {type: 'GuiUpdateMessage', uuid: '%UUID%', updates: {value: [switches, cell, ++n]}});
const beat = () => {
  if (board() && !D.hidden && D.hasFocus()) { live = true; send(down, over()); }
  else if (live) { live = false; down = 0; send(0, 0); }
};
const timer = setInterval(beat, %PERIOD%);
const on = (type, f) => W.addEventListener(type, f, {signal: stop.signal, capture: true});
stop.signal.addEventListener('abort', () => clearInterval(timer));
const ours = e => e.code in KEYS && board() && !e.ctrlKey && !e.metaKey && !e.altKey
  && !(e.target.closest && e.target.closest('input:not([type=checkbox]),textarea,select,[contenteditable=true]'));
on('keydown', e => {
  if (!ours(e)) return;
  e.preventDefault(); e.stopImmediatePropagation();
  if (e.repeat) return;
  clearTimeout(ups[e.code]);
  since[e.code] = performance.now(); down |= KEYS[e.code]; beat();
});
on('keyup', e => {
  if (!(e.code in KEYS) || !(down & KEYS[e.code])) return;
  e.preventDefault(); e.stopImmediatePropagation();
  const up = () => { down &= ~KEYS[e.code]; beat(); }, left = since[e.code] + TAP - performance.now();
  if (left > 0) ups[e.code] = setTimeout(up, left); else up();
});
on('pointermove', e => { x = e.clientX; y = e.clientY; });
for (const type of ['pointerup', 'pointercancel'])
  on(type, e => { if (e.pointerType === 'touch') { x = -1; beat(); } });
D.addEventListener('pointerleave', () => { x = -1; beat(); }, {signal: stop.signal});
on('blur', e => { if (e.target === W) { down = 0; x = -1; beat(); } });
on('pagehide', () => { down = 0; x = -1; beat(); });
})()
"""


def board_html(view: ScanView, settings: ScanSettings) -> str:
    """Return the board of commands, in which the highlighted one is marked."""
    cells = []
    for command in _CELLS:
        if command is None:
            cells.append("<div></div>")
            continue
        classes = "cell"
        if command == view.driving:
            classes += " driving"
        elif command == view.lit:
            classes += " armed" if view.armed else " lit"
        rests = command == view.lit and view.resting and view.driving is None
        bar = f'<i style="animation-duration:{settings.dwell:g}s"></i>' if rests else ""
        cells.append(
            f'<div class="{classes}" data-scan="{_NAMES.index(command) + 1}">{command.capitalize()}{bar}</div>'
        )
    hint = _HINTS[settings.method] + (" Select twice to confirm." if settings.confirm else "")
    return block("scan", f'<div class="iw-scan" id="iw-scan">{"".join(cells)}</div><div class="iw-small">{hint}</div>')


class ScanPanel:
    """The board of one page and its settings.

    Args:
        gui: Makes the elements, in the open container.
        on_stick: Called with forward and turn (positive to the left), each in [-1, 1], and a message count, once per
            message of the page while a command drives, and with 0, 0 when it ends.
        now: A monotonic clock, in seconds.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        *,
        on_stick: Callable[[float, float, int], None],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._on_stick, self._now = on_stick, now
        self._able = self._moves = False
        self._selected: str | None = None
        self._count = 0
        gui.add_html(STYLE_SHEET)
        self.method: viser.GuiDropdownHandle[str] = gui.add_dropdown(
            "Scanning", (OFF, *METHOD_LABELS), hint="Drive with one or two switches (Space, Enter) or a resting pointer"
        )
        self.seconds = gui.add_number("Seconds", 1.5, min=SHORTEST, max=LONGEST, step=0.1, visible=False)
        self.confirm = gui.add_checkbox("Select twice", False, visible=False)
        self.message = gui.add_vector3("scan", (0.0, 0.0, 0.0), visible=False)
        self._board = gui.add_html("")
        script = _SCRIPT.replace("%UUID%", element_id(self.message)).replace("%PERIOD%", f"{1000.0 / RATE:g}")
        gui.add_html(f'<img src="x:" alt="" style="display:none" onerror="{html.escape(script)}">')
        self._scan = SwitchScan(ScanSettings())
        updated(self.method, lambda _: self._restart())
        updated(self.seconds, lambda _: self._restart())
        updated(self.confirm, lambda _: self._restart())
        updated(self.message, self._heard)

    def show(self, snapshot: Snapshot, choices: Choices) -> None:
        """Show the board while scanning is on and the selected body can be driven."""
        able = can_drive(snapshot, choices) and not snapshot.is_over
        if able != self._able or choices.selected != self._selected:
            self._able, self._selected = able, choices.selected
            self._restart()

    def _restart(self) -> None:
        """Begin again with the settings as they are. Driving ends."""
        method = METHOD_LABELS.get(self.method.value)
        self.seconds.visible = self.confirm.visible = method is not None
        seconds = self.seconds.value
        # The values of a page are not trusted.
        valid = isinstance(seconds, int | float) and math.isfinite(seconds)
        seconds = min(max(float(seconds), SHORTEST), LONGEST) if valid else 1.5
        self._scan = SwitchScan(
            ScanSettings(method=method or "auto", period=seconds, dwell=seconds, confirm=bool(self.confirm.value))
        )
        self._drive(0.0, 0.0)
        self._draw()

    def _draw(self) -> None:
        is_on = self._able and self.method.value in METHOD_LABELS
        self._board.content = board_html(self._scan.view, self._scan.settings) if is_on else ""

    def _heard(self, value: tuple[float, float, float]) -> None:
        if not self._able or self.method.value not in METHOD_LABELS:
            return
        if len(value) != 3 or value[0] not in (0, 1, 2, 3) or value[1] not in range(len(_NAMES) + 1):
            return
        switches, cell = int(value[0]), int(value[1])
        before = self._scan.view
        pressed = [number for number in (1, 2) if switches & number]
        self._drive(*self._scan.update(self._now(), pressed, _NAMES[cell - 1] if cell else None))
        if self._scan.view != before:
            self._draw()

    def _drive(self, forward: float, turn: float) -> None:
        moved, self._moves = self._moves, bool(forward or turn)
        if moved or self._moves:
            self._count += 1
            self._on_stick(GENTLE * forward, GENTLE * turn, self._count)
