"""The table of all bodies, agents first. A click on a row selects its body, and so does the list below."""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import Final

import viser

from intellwheels_schemas.agent_colours import natural_key
from intellwheels_schemas.messages import Body, Entity
from intellwheels_viewer.panels import number_format
from intellwheels_viewer.panels.callbacks import Pick, assign, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.commands import agent_command
from intellwheels_viewer.panels.marks import Mark, swatch
from intellwheels_viewer.panels.ranges import nearest, tone
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block, note
from intellwheels_viewer.snapshot import Snapshot

ROWS: Final = 40
"""Rows of the table; the list below has all bodies."""
NOBODY: Final = "Nobody"
"""No agent can have this name: names are lower case."""
_STATES: Final = {
    "drive": "",
    "timeout": "no command",
    "rested": "resting",
    "paused": "paused",
    "taken": "taken over",
    "stale": "stale: no recent pose",
}
_COLUMNS: Final = (
    '<colgroup><col><col style="width:46px"><col style="width:52px"><col style="width:54px"></colgroup>'
    "<tr><th>agent</th><th>speed<br>m/s</th><th>nearest<br>m</th><th>contacts</th></tr>"
)


def agents_first(snapshot: Snapshot) -> list[Entity]:
    """Return the bodies in natural order of their names, agents before bodies that an operator placed."""
    return sorted(
        snapshot.entities,
        key=lambda entity: (not _is_agent(snapshot.bodies.get(entity.name)), natural_key(entity.name)),
    )


def agents_html(snapshot: Snapshot, choices: Choices, handler: str = "") -> str:
    """Return the table of bodies.

    Args:
        snapshot: The run.
        choices: The selected body and the colours.
        handler: An HTML attribute of the table that makes its `data-agent` rows selectable.
    """
    if not snapshot.entities:
        return block(
            "agents", note(f"No agents yet. Add one: `{agent_command(snapshot)}`") if snapshot.phase == "live" else ""
        )
    known = {name: Mark(*look) for name, look in choices.looks.items()}
    bodies = agents_first(snapshot)
    shown = bodies[:ROWS]
    if choices.selected not in {entity.name for entity in shown}:
        shown = [*shown, *(entity for entity in bodies[ROWS:] if entity.name == choices.selected)]
    rows = "".join(_row(snapshot, entity, known.get(entity.name, Mark()), choices.selected) for entity in shown)
    rest = len(bodies) - len(shown)
    more = f'<div class="iw-small">and {rest} more: use the list below</div>' if rest else ""
    old = "" if snapshot.phase == "live" else "iw-old"
    return block("agents", f"<table {handler}>{_COLUMNS}{rows}</table>{more}", classes=old)


def words(entity: Entity, body: Body | None) -> str:
    """Return the status of a body in words: kind, real or simulated, mode, why it does not drive, slow commands."""
    said = []
    if body is not None:
        said.append(body.robot.type if _is_agent(body) else f"{body.robot.kind}, placed")
    if entity.mode:
        said.append(entity.mode)
    if _STATES[entity.state]:
        said.append(_STATES[entity.state])
    if entity.command_age:
        said.append(f"commands {number_format.decimal(entity.command_age)} s old")
    return ", ".join(said)


def _is_agent(body: Body | None) -> bool:
    # A body that an operator placed has no instance that joined. In a playback no body has an owner.
    return body is None or body.owner is not None or body.robot.instance is not None


def _row(snapshot: Snapshot, entity: Entity, mark: Mark, selected: str | None) -> str:
    name = html.escape(entity.name)
    classes = " ".join(
        word for word, on in (("chosen", entity.name == selected), ("stale", entity.state == "stale")) if on
    )
    distance = nearest(snapshot, entity.name)
    near = "\u2013" if distance is None else number_format.decimal(distance)
    return (
        f'<tr class="{classes}" data-agent="{name}" data-testid="agent-{name}" data-state="{entity.state}">'
        f'<td><div class="iw-head">{swatch(mark)}<b class="iw-cut" title="{name}">{name}</b></div>'
        f'<div class="iw-small iw-wide">{html.escape(words(entity, snapshot.bodies.get(entity.name)))}</div></td>'
        f"<td><span>{number_format.decimal(entity.speed)}</span></td>"
        f'<td><span class="{"iw-near" if distance is not None and tone(distance) == "near" else ""}">{near}</span></td>'
        f"<td>{_contacts(entity)}</td></tr>"
    )


def _contacts(entity: Entity) -> str:
    if entity.contact or entity.collision:
        return f'<b class="iw-red">{entity.contacts}</b><div class="iw-small iw-red">touching</div>'
    return f"<span>{entity.contacts}</span>"


class AgentsPanel:
    """The table, and a list of all names.

    Args:
        gui: Makes the elements, in the open container.
        on_select: Called with the name of a body in the run, or None.
    """

    def __init__(self, gui: viser.GuiApi, on_select: Callable[[str | None], None]) -> None:
        gui.add_html(STYLE_SHEET)
        self._table = gui.add_html("")
        self._list: viser.GuiDropdownHandle[str] = gui.add_dropdown("Selected", (NOBODY,))
        self._known: frozenset[str] = frozenset()
        self._on_select = on_select
        self._pick = Pick(gui, self._selected)
        updated(self._list, self._selected)

    def show(self, snapshot: Snapshot, choices: Choices) -> None:
        """Show the bodies of a snapshot."""
        self._table.content = agents_html(snapshot, choices, self._pick.attribute)
        names = tuple(entity.name for entity in agents_first(snapshot))
        self._known = frozenset(names)
        options = (NOBODY, *names)
        if options != self._list.options:
            self._list.options = options
        assign(self._list, choices.selected if choices.selected in options else NOBODY)
        self._list.visible = bool(names)

    def _selected(self, name: str) -> None:
        if name in self._known:
            self._on_select(name)
        elif name == NOBODY:
            self._on_select(None)
