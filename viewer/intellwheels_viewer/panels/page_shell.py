"""What a page has outside its panels: a bar within reach of a thumb, the list of keys, and what its window is like.

A narrow window has the bar at its bottom edge: state and time, pause, and buttons that open the list of agents, the
stick and the events. The script makes these in the page's body, because a panel that is closed hides what is in it. It
uses a private name of viser (see callbacks). It is run by an image, so a bare `URL` in it is the document's.
"""

from __future__ import annotations

import html
import json
from collections.abc import Callable
from typing import Final

import msgspec
import viser

from intellwheels_viewer.panels.callbacks import element_id, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.number_format import decimal
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET
from intellwheels_viewer.snapshot import Snapshot

ACTS: Final = ("pause", "link", "record", "video")
"""What the page asks this process for; it does all else itself."""
PHONE: Final = 576
"""Widest window of a phone in px, where viser has a sheet in place of panels."""
NARROW: Final = 1000
"""Width in px below which an upright window has the bar: with two panels beside it, the scene would be a strip."""
KEYS: Final = (
    ("W A S D, arrows, I J K L", "drive the selected chair while they are held; with Shift at full power"),
    ("Q, E", "drive in a bend"),
    ("Mouse", "drag turns the view, right drag moves it, the wheel zooms"),
    ("1 to 9", "select a body, in the order of the names"),
    ("Space", "pause, resume or run again"),
    ("N", "one step of a paused run"),
    ("O, P, F, H", "camera: free, plan, follow, from the chair"),
    ("Escape", "stop placing"),
    ("Z", "undo the last move"),
    ("Ctrl K", "find a command by its name"),
    ("?", "these keys"),
)

_BAR: Final = (
    '<button type="button" data-iw="pause" class="iw-now" aria-label="Pause or resume">'
    '<i id="iw-bar-act" aria-hidden="true">\u2013</i><b id="iw-bar-time">\u2013</b>'
    '<span id="iw-bar-state"></span></button>'
    '<button type="button" data-iw="open" data-tab="Agents">List</button>'
    '<button type="button" data-iw="open" data-tab="Drive">Stick</button>'
    '<button type="button" data-iw="open" data-tab="Events">Events</button>'
    '<button type="button" data-iw="keys" aria-label="Keys and help">?</button>'
)
_HELP: Final = (
    '<h2>Keys</h2><table role="presentation">'
    + "".join(f"<tr><th>{html.escape(key)}</th><td>{html.escape(does)}</td></tr>" for key, does in KEYS)
    + "</table><p>Keys work whichever tab is open, but not while a text field has the focus. "
    "iw-joystick takes the same keys to drive, in its window and in a terminal.</p>"
    '<form method="dialog"><button>Close</button></form>'
)

_SCRIPT: Final = """
(() => {
const W = window, D = document;
if (W.__iwShell) W.__iwShell.abort();
const stop = W.__iwShell = new AbortController();
const tell = (uuid, value) => W.__viserMutable.sendMessage({type: 'GuiUpdateMessage', uuid, updates: {value}});
const on = (at, type, f) => at.addEventListener(type, f, {signal: stop.signal, capture: true});
const make = (tag, id, inner) => {
  const made = D.createElement(tag);
  made.id = id; made.className = 'iw-shell'; made.innerHTML = inner;
  D.body.append(made);
  stop.signal.addEventListener('abort', () => made.remove());
  return made;
};
const bar = make('nav', 'iw-bar', %BAR%), keys = make('dialog', 'iw-keys', %HELP%);
bar.setAttribute('aria-label', 'Run and panels');
const sheet = () => D.querySelector('.mantine-Paper-root[style*="max-height: 60%"]');
const press = at => {
  for (const type of ['pointerdown', 'pointerup'])
    at.dispatchEvent(new PointerEvent(type, {bubbles: true, cancelable: true, isPrimary: true, pointerId: 1}));
  at.click();
};
const events = (tries, seen) => {
  // The panel opens in many small steps, and on a slow machine late.
  const list = D.querySelector('[data-testid=events]'), row = list && list.parentElement.previousElementSibling;
  const view = row && row.closest('.mantine-ScrollArea-viewport');
  if (view) row.scrollIntoView({block: 'start'});
  const [at, from] = [row, view].map(one => one ? one.getBoundingClientRect().top : 0);
  const there = view && view.clientHeight && Math.abs(at - from) < 2;
  if (tries && !(there && seen) && D.body.dataset.iwOpen === 'Events') setTimeout(events, 200, tries - 1, there);
};
const open = tab => {
  const here = D.body.dataset.iwOpen === tab;
  D.body.dataset.iwOpen = here && sheet() ? '' : tab;
  if (tab === 'Events') {
    const run = D.querySelector('[aria-label="Expand panel Run"]');
    if (run) run.click();
    events(15, false);
  } else {
    const found = [...D.querySelectorAll('[role=tab]')].find(one => one.innerText.trim() === tab);
    if (found) { press(found); found.scrollIntoView({block: 'start'}); }
  }
};
const picture = () => {
  W.__viserMutable.requestRender();
  requestAnimationFrame(() => requestAnimationFrame(() => W.__viserMutable.canvas.toBlob(data => {
    const link = D.createElement('a'), now = D.getElementById('iw-status');
    link.href = W.URL.createObjectURL(data);
    link.download = `intellwheels-${now ? now.dataset.tick : 0}.png`;
    link.click();
    setTimeout(() => W.URL.revokeObjectURL(link.href), 10000);
  })));
};
on(D, 'click', e => {
  const at = e.target.closest && e.target.closest('[data-iw]');
  if (!at || at.disabled) return;
  const act = at.dataset.iw;
  if (act === 'open') open(at.dataset.tab);
  else if (act === 'keys') keys.showModal();
  else if (act === 'commands')
    D.documentElement.dispatchEvent(
      new KeyboardEvent('keydown', {key: 'k', code: 'KeyK', ctrlKey: true, bubbles: true}));
  else if (act === 'picture') picture();
  else tell('%ACT%', `${act} ${Date.now()}`);
});
on(D, 'keydown', e => {
  if (e.key !== '?' || e.ctrlKey || e.metaKey || e.altKey || keys.open) return;
  if (e.target.closest && e.target.closest('input,textarea,select,[contenteditable=true]')) return;
  e.preventDefault();
  keys.showModal();
});
on(keys, 'click', e => { if (e.target === keys) keys.close(); });
const dark = W.matchMedia('(prefers-color-scheme: dark)');
let told = '', query = W.location.search;
const covered = () => {
  const box = W.__viserMutable.canvas && W.__viserMutable.canvas.getBoundingClientRect();
  if (!box || !box.height || getComputedStyle(bar).display === 'none') return 0;
  const tops = [bar, sheet(), ...D.querySelectorAll('[data-floating-window]')]
    .filter(at => at && getComputedStyle(at).visibility !== 'hidden')
    .map(at => at.getBoundingClientRect()).filter(one => one.height && one.bottom > box.bottom - 80);
  return Math.max(0, Math.min(0.8, (box.bottom - Math.min(box.bottom, ...tops.map(one => one.top))) / box.height));
};
const look = () => {
  const now = D.getElementById('iw-status');
  if (now) {
    D.getElementById('iw-bar-time').textContent = now.dataset.time;
    D.getElementById('iw-bar-state').textContent = now.dataset.state;
    const act = D.getElementById('iw-bar-act');
    act.textContent = now.dataset.act; act.className = now.dataset.tone;
    bar.querySelector('[data-tab=Drive]').hidden = !now.dataset.drives;
  }
  // Names that viser leaves out, for screen readers.
  for (const one of D.querySelectorAll('label[for]')) {
    const line = one.control ? null : one.closest('p') && one.closest('p').parentElement.parentElement;
    const field = line && line.querySelector('input:not([aria-label])');
    if (field) field.setAttribute('aria-label', one.innerText);
  }
  for (const [icon, name] of [['list-search', 'Find a command'], ['adjustments', 'Settings']])
    for (const one of D.querySelectorAll(`button:not([aria-label]):has(> * > .tabler-icon-${icon})`))
      one.setAttribute('aria-label', name);
  for (const one of bar.querySelectorAll('[data-tab]'))
    one.setAttribute('aria-pressed', String(D.body.dataset.iwOpen === one.dataset.tab));
  if (!W.__viserMutable || !W.__viserMutable.sendMessage) return;
  const box = W.__viserMutable.canvas ? W.__viserMutable.canvas.getBoundingClientRect() : {width: 0, height: 1};
  const news = JSON.stringify({
    width: W.innerWidth, height: W.innerHeight, dark: dark.matches, covered: Math.round(covered() * 100) / 100,
    aspect: Math.round(1000 * box.width / Math.max(1, box.height)) / 1000, query});
  if (news !== told) { told = news; tell('%WINDOW%', news); }
};
const timer = setInterval(look, 250);
stop.signal.addEventListener('abort', () => clearInterval(timer));
on(W, 'resize', look);
look();
})()
"""


class Window(msgspec.Struct, frozen=True):
    """What a page says about its window.

    Attributes:
        width, height: In px.
        dark: Whether the system wants dark pages.
        covered: Share of the scene's height that is behind panels at its bottom, in [0, 0.8].
        aspect: Width of the scene over its height; 0 while it is not known.
        query: The query of the page's address, with its question mark.
    """

    width: float = 1280.0
    height: float = 800.0
    dark: bool = False
    covered: float = 0.0
    aspect: float = 0.0
    query: str = ""


def window_of(text: str) -> Window | None:
    """Return what a page said, or None if it is nothing of this form: a page can send anything."""
    try:
        found = msgspec.json.decode(text.encode(), type=Window)
    except (msgspec.DecodeError, UnicodeEncodeError):
        return None
    sizes = 1.0 <= found.width <= 1e5 and 1.0 <= found.height <= 1e5
    shares = 0.0 <= found.covered <= 0.8 and 0.0 <= found.aspect <= 1e5
    return found if sizes and shares and len(found.query) <= 2000 else None


def script_html(act: str, window: str) -> str:
    """Return the script, which is written once.

    Args:
        act: The id of the element to which it sends what the user wants, see `ACTS`.
        window: The id of that to which it sends what the window is like.
    """
    script = _SCRIPT.replace("%BAR%", json.dumps(_BAR)).replace("%HELP%", json.dumps(_HELP))
    script = script.replace("%ACT%", act).replace("%WINDOW%", window)
    return f'<img src="x:" alt="" style="display:none" onerror="{html.escape(script)}">'


def status_html(snapshot: Snapshot, choices: Choices) -> str:
    """Return the state of the run for the bar, as data of an element that nobody sees."""
    clock = snapshot.clock
    live = snapshot.phase == "live" and clock is not None
    state = clock.state if live and clock is not None else ""
    word = {"running": "Running", "waiting": "Waiting", "paused": "Paused", "ended": "Ended"}.get(state, "No run")
    act = "\u275a\u275a" if state in ("running", "waiting") else "\u25b6" if live else "\u2013"
    tone = "good" if state == "running" else "wait" if live else "bad"
    time, tick = (0.0, 0) if clock is None else (clock.time, clock.tick)
    drives = "1" if snapshot.last_tick is None and not choices.rights.looks_only else ""
    return (
        f'<i id="iw-status" hidden data-act="{act}" data-state="{word}" data-tone="{tone}" '
        f'data-time="{decimal(time, 1)} s" data-tick="{tick}" data-drives="{drives}"></i>'
    )


def tools_html(*, recording: bool, video: bool = False) -> str:
    """Return the buttons for keys, commands, pictures, recordings and links."""
    record = "Save" if recording else "Record"
    buttons = (
        ("keys", "Keys", "The keys (?)"),
        ("commands", "Find", "Find a command by its name (Ctrl K)"),
        ("picture", "Picture", "Save the scene as a PNG file"),
        ("record", record, "Record the run as a page that plays without a server; press again to save it"),
        ("video", "Save" if video else "Video", "Record this view as an MP4 file; press again to save it"),
        ("link", "Link", "Copy a link to this view: camera, selection and tick"),
    )
    pressed = {act: ' aria-pressed="true"' for act, runs in (("record", recording), ("video", video)) if runs}
    row = "".join(
        f'<button type="button" data-iw="{act}" title="{html.escape(title)}"{pressed.get(act, "")}>{word}</button>'
        for act, word, title in buttons
    )
    return f'<div class="iw" data-testid="tools"><div class="iw-tools">{row}</div></div>'


def link_html(query: str) -> str:
    """Return a script that puts a query into the page's address and the address into the clipboard."""
    code = (
        f"history.replaceState(null,'',{json.dumps(query)});"
        "if(navigator.clipboard)navigator.clipboard.writeText(location.href).catch(()=>0)"
    )
    return f'<img src="x:" alt="" style="display:none" onerror="{html.escape(code)}">'


class PageShell:
    """The bar, the keys and the window of one browser.

    Args:
        gui: Makes the elements, in the open container.
        on_act: Called with one of `ACTS`.
        on_window: Called when the window is another.
    """

    def __init__(self, gui: viser.GuiApi, on_act: Callable[[str], None], on_window: Callable[[Window], None]) -> None:
        self._gui = gui
        self._act, self._window = (gui.add_text(name, "", visible=False) for name in ("act", "window"))
        self._on_act, self._on_window = on_act, on_window
        updated(self._act, self._acted)
        updated(self._window, self._changed)
        gui.add_html(STYLE_SHEET)
        self._status = gui.add_html("")
        self._link = gui.add_html("")
        self._script = gui.add_html(script_html(element_id(self._act), element_id(self._window)))

    def show(self, snapshot: Snapshot, choices: Choices) -> None:
        """Show the state of a run in the bar."""
        self._status.content = status_html(snapshot, choices)

    def copy_link(self, query: str) -> None:
        """Put a query into the page's address, and copy the address."""
        self._link.content = ""
        self._link.content = link_html(query)

    def _acted(self, text: str) -> None:
        act = text.partition(" ")[0]
        if act in ACTS:
            self._on_act(act)

    def _changed(self, text: str) -> None:
        window = window_of(text)
        if window is not None:
            self._on_window(window)
