"""Whether there is a world, in words: what is wrong, and what to do about it."""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import Final, NamedTuple

import viser

from intellwheels_viewer.panels.callbacks import assign, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block, note, prose
from intellwheels_viewer.snapshot import Snapshot

NO_WORLD: Final = "Choose one"
GREYED: Final = "<style>canvas,.iw-plan svg{filter:grayscale(1) opacity(.55)}</style>"
"""The picture is of the past: no colour says so of what is drawn."""


class State(NamedTuple):
    """The state of the connection: a tone (good, wait or bad), a headline and what to do or know."""

    tone: str
    title: str
    text: str


def state(seen: Snapshot, choices: Choices) -> State:
    """Return the connection's state in words."""
    silence = f"Simulator silent for {choices.quiet:.0f} s"
    world = seen.world or "the world"
    return {
        "no-router": State(
            "bad", f"No router at {seen.endpoint}", "Start `iw-router`. This page connects as soon as it is there."
        ),
        "no-world": State(
            "wait", "No world is running", "Start `iw-run figure6`. This page shows it as soon as it is there."
        ),
        "choose": _choice(seen),
        "silent": State("bad", silence, "Last picture, greyed. It goes on by itself when the simulator answers."),
        "gone": State("bad", f"World {world} has gone", "Last picture, greyed. It comes back when its simulator does."),
        "live": State("good", _floor(seen), f"World {world} at {seen.endpoint}"),
    }[seen.phase]


def nothing_to_see(seen: Snapshot, choices: Choices) -> str:
    """Return the state as plain lines for a scene without a floor; nothing where there is one."""
    if seen.floor is not None:
        return ""
    now = state(seen, choices)
    return f"{now.title}\n" + now.text.replace("`", "").replace(". ", ".\n")


def connection_html(seen: Snapshot, choices: Choices) -> str:
    """Return the state with a dot, its text, and whether this viewer may only look."""
    now = state(seen, choices)
    size = "iw-small" if now.tone == "good" else "iw-soft"
    content = (
        f'<div class="iw-head"><i class="iw-dot {now.tone}"></i><b>{html.escape(now.title)}</b></div>'
        f'<div class="{size}">{prose(now.text)}</div>'
    )
    if seen.phase == "live" and not choices.allowed:
        content += note("You may look, not steer: this viewer has no right to control.", "wait")
    if choices.refusal:
        refused = note(choices.refusal.replace("`", "'"), "bad")
        content += f'<div role="alert">{refused}</div>'
    if seen.phase in ("silent", "gone"):
        content += GREYED
    return block("connection", f'<div data-phase="{seen.phase}">{content}</div>')


def _choice(seen: Snapshot) -> State:
    if seen.world:
        return State("wait", f"World {seen.world} is not running", "It is shown as soon as it is; or choose another.")
    count = len(seen.worlds)
    running = "1 world is running" if count == 1 else f"{count} worlds are running"
    return State("wait", running, "Choose the one to look at.")


def _floor(seen: Snapshot) -> str:
    return (seen.floor.title or seen.floor.name) if seen.floor else "Connected, waiting for the floor"


class ConnectionPanel:
    """The state, and the list of worlds where there are several.

    Args:
        gui: Where the elements are made, in the container that is open.
        on_world: Gets the name of a world that is there.
    """

    def __init__(self, gui: viser.GuiApi, on_world: Callable[[str], None]) -> None:
        gui.add_html(STYLE_SHEET)
        self._words = gui.add_html("")
        self._worlds: viser.GuiDropdownHandle[str] = gui.add_dropdown("World", (NO_WORLD,), visible=False)
        self._known: tuple[str, ...] = ()
        self._on_world = on_world
        updated(self._worlds, self._chosen)

    def show(self, seen: Snapshot, choices: Choices) -> None:
        """Show the state of now."""
        self._words.content = connection_html(seen, choices)
        self._known = seen.worlds
        options = seen.worlds if seen.world in seen.worlds else (NO_WORLD, *seen.worlds)
        if options != self._worlds.options:
            self._worlds.options = options
        assign(self._worlds, seen.world if seen.world in seen.worlds else NO_WORLD)
        self._worlds.visible = any(world != seen.world for world in seen.worlds)

    def _chosen(self, world: str) -> None:
        if world in self._known:
            self._on_world(world)
