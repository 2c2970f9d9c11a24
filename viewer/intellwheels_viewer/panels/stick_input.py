"""The keys and the stick of a page, in elements that are there whichever tab is open.

The keys are those of `iw-joystick`, but for U and O, as O chooses a camera.

A page makes the elements of a tab only when the tab is opened for the first time, so these stand outside the tabs. The
page sends ten messages a second while the stick is moved or a key is down, and a zero when it is released, the page
loses the focus or is hidden. The script uses a private name of viser (see callbacks).
"""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import Final

import viser

from intellwheels_viewer.panels.callbacks import element_id, updated

RATE: Final = 10.0
"""Stick messages per second."""
GENTLE: Final = 0.6
"""Share of full power that a key gives; with Shift it gives full power."""

_SCRIPT: Final = """
(() => {
const W = window, D = document, GENTLE = %GENTLE%, R = 38;
if (W.__iwDrive) W.__iwDrive.abort();
const stop = W.__iwDrive = new AbortController();
const KEYS = {
  KeyI: [1, 0], KeyK: [-1, 0], KeyJ: [0, 1], KeyL: [0, -1], KeyW: [1, 0], KeyS: [-1, 0], KeyA: [0, 1], KeyD: [0, -1],
  ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1], KeyQ: [1, 1], KeyE: [1, -1]};
// A tab, a slider or a list that was reached with the Tab key needs the arrows itself.
const OWN = 'input,[role=tab],[role=slider],[role=listbox],[role=combobox],[role=radio],[role=textbox],dialog';
const down = new Set();
let tabbed = false, stick = null, pointer = null, shift = false, timer = null, moving = false, n = 0;
const clamp = v => Math.max(-1, Math.min(1, v));
const command = () => {
  if (D.getElementById('iw-drive-off')) return [0, 0];
  if (stick) return stick;
  let f = 0, t = 0;
  for (const k of down) { f += KEYS[k][0]; t += KEYS[k][1]; }
  const p = shift ? 1 : GENTLE;
  return [clamp(f) * p, clamp(t) * p];
};
const send = (f, t) => W.__viserMutable.sendMessage(
  {type: 'GuiUpdateMessage', uuid: '%UUID%', updates: {value: [f, t, ++n]}});
const beat = () => {
  const [f, t] = command(), knob = D.getElementById('iw-knob');
  if (knob) knob.style.transform = `translate(${-t * R}px,${-f * R}px)`;
  if (f || t) { send(f, t); moving = true; timer = timer || setInterval(beat, %PERIOD%); return; }
  if (moving) send(0, 0);
  moving = false; clearInterval(timer); timer = null;
};
const release = () => { down.clear(); stick = null; pointer = null; beat(); };
const on = (type, f) => W.addEventListener(type, f, {signal: stop.signal, capture: true});
stop.signal.addEventListener('abort', release);
on('pointerdown', () => { tabbed = false; });
on('keydown', e => {
  if (e.key === 'Tab') tabbed = true;
  if (!(e.code in KEYS) || e.ctrlKey || e.metaKey || e.altKey) return;
  const at = e.target;
  if (at.closest && at.closest('textarea,select,[contenteditable=true],input:not([type=checkbox]):not([type=range])'))
    return;
  if (e.code.startsWith('Arrow') && at.closest && tabbed && at.closest(OWN)) return;
  // These keys would move viser's camera too, or scroll. The camera has the mouse.
  e.preventDefault(); e.stopPropagation();
  if (e.repeat) return;
  shift = e.shiftKey; down.add(e.code); beat();
});
on('keyup', e => { shift = e.shiftKey; if (down.delete(e.code)) beat(); });
const pull = e => {
  const area = D.getElementById('iw-stick');
  if (!area) return release();
  const b = area.getBoundingClientRect();
  let x = (e.clientX - b.left - b.width / 2) / R, y = (b.top + b.height / 2 - e.clientY) / R;
  const r = Math.hypot(x, y);
  if (r > 1) { x /= r; y /= r; }
  stick = r < 0.12 ? [0, 0] : [y, -x];
  if (!timer || r < 0.12) beat();
};
on('pointerdown', e => {
  if (e.button || !(e.target.closest && e.target.closest('#iw-stick'))) return;
  pointer = e.pointerId; e.preventDefault(); pull(e);
});
on('pointermove', e => { if (e.pointerId === pointer) pull(e); });
for (const type of ['pointerup', 'pointercancel'])
  on(type, e => { if (e.pointerId === pointer) release(); });
on('blur', e => { if (e.target === W) release(); });
on('pagehide', release);
D.addEventListener('visibilitychange', () => { if (D.hidden) release(); }, {signal: stop.signal});
})()
"""
_OFF: Final = '<i id="iw-drive-off" hidden></i>'
"""The script looks for this element: stick and keys send nothing while it exists."""


def script_html(element: str) -> str:
    """Return the script. It is written once: rewriting it would release a key that is held.

    Args:
        element: The id of the element to which it sends.
    """
    script = _SCRIPT.replace("%UUID%", element).replace("%GENTLE%", str(GENTLE)).replace("%PERIOD%", str(1000 / RATE))
    return f'<img src="x:" alt="" style="display:none" onerror="{html.escape(script)}">'


class StickInput:
    """What a page's stick and keys send.

    Args:
        gui: Makes the elements, in the open container.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        self.value = gui.add_vector3("stick", (0.0, 0.0, 0.0), visible=False)
        self._off = gui.add_html(_OFF)
        self._script = gui.add_html(script_html(element_id(self.value)))

    def listen(self, call: Callable[[tuple[float, float, float]], None]) -> None:
        """Call with each message: forward and turn (positive to the left), each in [-1, 1], and a message count."""
        updated(self.value, call)

    def enable(self, able: bool) -> None:
        """Let the page send, or not."""
        self._off.content = "" if able else _OFF

    def remove(self) -> None:
        """Remove the elements."""
        for element in (self.value, self._off, self._script):
            element.remove()
