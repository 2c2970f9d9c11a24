"""Lets the keys of the page work wherever the focus is, except in text fields.

A click on a button or a tab leaves the focus there, and the browser or viser gives it the keys, above all Space. A
script in the page sends such a key to the page instead. Who moves the focus with the Tab key still presses with Space.
"""

from __future__ import annotations

import html
from typing import Final

import viser

_SCRIPT: Final = """
(() => {
const W = window, D = document;
if (W.__iwKeys) W.__iwKeys.abort();
const stop = W.__iwKeys = new AbortController();
const PRESSED = ['button', 'checkbox', 'image', 'radio', 'range', 'reset', 'submit'];
let tabbed = false;
const on = (type, f) => W.addEventListener(type, f, {signal: stop.signal, capture: true});
const typed = at => at.closest('textarea,select,[contenteditable=true]')
  || (at.tagName === 'INPUT' && !PRESSED.includes(at.type));
const ours = e => {
  if (!e.isTrusted || e.ctrlKey || e.metaKey || e.altKey || e.key.length !== 1) return false;
  const at = e.target;
  if (!at.closest || at === D.body || at === D.documentElement || at.tagName === 'CANVAS' || typed(at)) return false;
  return !(tabbed && e.key === ' ');
};
on('pointerdown', () => { tabbed = false; });
on('keydown', e => {
  if (e.key === 'Tab') tabbed = true;
  if (!ours(e)) return;
  e.preventDefault(); e.stopImmediatePropagation();
  D.body.dispatchEvent(new KeyboardEvent('keydown', {
    key: e.key, code: e.code, shiftKey: e.shiftKey, repeat: e.repeat, bubbles: true, cancelable: true}));
});
// A list is a text field too. Once something was chosen from it, nobody types there.
on('click', e => {
  if (e.target.closest && e.target.closest('[role=option]')) setTimeout(() => D.activeElement.blur());
});
on('keyup', e => { if (e.key === ' ' && ours(e)) e.preventDefault(); });
})()
"""


class PageKeys:
    """The script of one browser.

    Args:
        gui: Makes the element, in the open container. A page makes what is in a tab only when the tab is opened.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        self._script = gui.add_html(f'<img src="x:" alt="" style="display:none" onerror="{html.escape(_SCRIPT)}">')
