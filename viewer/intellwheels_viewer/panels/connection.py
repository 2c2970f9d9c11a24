"""The state of the connection in words: what is wrong and what to do about it."""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import Final, NamedTuple

import viser

from intellwheels_viewer.drivers import reality_of
from intellwheels_viewer.page_title import reality
from intellwheels_viewer.panels.callbacks import assign, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.commands import is_local, run_command
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block, note, prose
from intellwheels_viewer.snapshot import Snapshot
from intellwheels_viewer.steering import VIEW_ONLY

NO_WORLD: Final = "Choose a world"
STAND_IN: Final = "Stand-in: its bridge is that of a real chair, its hardware is simulated."
"""Said where a chair is one."""
GREYED: Final = "<style>canvas,.iw-plan svg{filter:grayscale(1) opacity(.55)}</style>"
"""Greys out the picture while it is out of date."""


_LAST: Final = "This is the last picture. It updates again"


class State(NamedTuple):
    """The state of the connection: a tone (good, wait or bad), a title and an explanation."""

    tone: str
    title: str
    text: str


def state(snapshot: Snapshot, choices: Choices) -> State:
    """Return the connection's state in words."""
    silence = f"Simulator silent for {choices.quiet:.0f} s"
    world = snapshot.world or "the world"
    return {
        "no-router": State("bad", f"Nothing at {snapshot.endpoint}", _start(snapshot)),
        "no-world": State("wait", "No world is running", _start(snapshot)),
        "choose": _choice(snapshot),
        "silent": State("bad", silence, f"{_LAST} when the simulator answers."),
        "gone": _gone(snapshot, world),
        "live": State("good", _floor(snapshot), f"World {world} at {snapshot.endpoint}"),
    }[snapshot.phase]


def empty_scene_text(snapshot: Snapshot, choices: Choices) -> str:
    """Return the state as plain lines for a scene without a map; empty if there is a map."""
    if snapshot.floor is not None:
        return ""
    now = state(snapshot, choices)
    return f"{now.title}\n" + now.text.replace(": `", ":\n").replace("`. ", "\n").replace("`", "").replace(". ", ".\n")


def connection_html(snapshot: Snapshot, choices: Choices) -> str:
    """Return the state with a dot, its explanation, and a notice if this viewer may not control the simulation."""
    now = state(snapshot, choices)
    size = "iw-small" if now.tone == "good" else "iw-soft"
    content = (
        f'<div class="iw-head"><i class="iw-dot {now.tone}"></i><b>{html.escape(now.title)}</b></div>'
        f'<div class="{size}">{prose(now.text)}</div>'
    )
    if snapshot.phase == "live":
        lines = reality(snapshot)
        if any(reality_of(body.robot) == "stand-in" for body in snapshot.bodies.values()):
            lines.append(STAND_IN)
        content += "".join(f'<div class="iw-small">{html.escape(words)}</div>' for words in lines)
    if words := rights_words(snapshot, choices):
        content += note(words, "wait") if words.startswith(VIEW_ONLY) else f'<div class="iw-small">{prose(words)}</div>'
    if snapshot.phase in ("silent", "gone"):
        content += GREYED
    return block("connection", f'<div data-phase="{snapshot.phase}">{content}</div>')


def rights_words(snapshot: Snapshot, choices: Choices) -> str:
    """Return what this page may do, or that it may only look and why; empty if nothing limits it."""
    world = snapshot.world
    if not world and snapshot.phase == "no-world":
        return choices.rights.where_to_look()
    if unseen := choices.rights.why_not_see(world):
        return f"{VIEW_ONLY}: {unseen}" if snapshot.phase == "live" else unseen
    return choices.rights.summary(world) if snapshot.phase == "live" else ""


def _start(snapshot: Snapshot) -> str:
    where = "" if snapshot.phase != "no-router" or is_local(snapshot) else " on that machine"
    return f"Start a scene{where}: `{run_command(snapshot)}`. This page shows it as soon as it runs."


def _gone(snapshot: Snapshot, world: str) -> State:
    if snapshot.clock is not None and snapshot.clock.state == "ended":
        return State("wait", "The run is over", f"Its processes have ended. {_LAST} when world {world} starts again.")
    return State("bad", f"World {world} has gone", f"Its simulator stopped. {_LAST} when it returns.")


def _choice(snapshot: Snapshot) -> State:
    if snapshot.world:
        return State(
            "wait",
            f"World {snapshot.world} is not running",
            "It appears here when it starts. You can choose another world.",
        )
    count = len(snapshot.worlds)
    running = "1 world is running" if count == 1 else f"{count} worlds are running"
    return State("wait", running, "Choose the world to show.")


def _floor(snapshot: Snapshot) -> str:
    return (snapshot.floor.title or snapshot.floor.name) if snapshot.floor else "Connected, loading the map"


class ConnectionPanel:
    """The state, and a list of worlds if there are several.

    Args:
        gui: Makes the elements, in the open container.
        on_world: Called with the name of a running world.
    """

    def __init__(self, gui: viser.GuiApi, on_world: Callable[[str], None]) -> None:
        gui.add_html(STYLE_SHEET)
        self._words = gui.add_html("")
        self._worlds: viser.GuiDropdownHandle[str] = gui.add_dropdown("World", (NO_WORLD,), visible=False)
        self._known: tuple[str, ...] = ()
        self._on_world = on_world
        updated(self._worlds, self._chosen)

    def show(self, snapshot: Snapshot, choices: Choices) -> None:
        """Show the current state."""
        self._words.content = connection_html(snapshot, choices)
        self._known = snapshot.worlds
        options = snapshot.worlds if snapshot.world in snapshot.worlds else (NO_WORLD, *snapshot.worlds)
        if options != self._worlds.options:
            self._worlds.options = options
        assign(self._worlds, snapshot.world if snapshot.world in snapshot.worlds else NO_WORLD)
        self._worlds.visible = any(world != snapshot.world for world in snapshot.worlds)

    def _chosen(self, world: str) -> None:
        if world in self._known:
            self._on_world(world)
