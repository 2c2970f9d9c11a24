"""The table of all bodies, agents first. A click on a row selects its body, and so does the list below."""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import Final

import viser

from intellwheels_schemas.agent_colours import natural_key
from intellwheels_schemas.messages import Body, Entity, Measures
from intellwheels_viewer.drivers import driver_of, reality_of, reality_words
from intellwheels_viewer.panels import number_format
from intellwheels_viewer.panels.callbacks import Pick, assign, updated
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.commands import agent_command
from intellwheels_viewer.panels.marks import Mark, swatch
from intellwheels_viewer.panels.ranges import nearest, tone
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block, note
from intellwheels_viewer.range_bands import NEAR
from intellwheels_viewer.snapshot import Snapshot

ROWS: Final = 40
"""Rows of the table; the list below has all bodies."""
NOBODY: Final = "Nobody"
"""No agent can have this name: names are lower case."""
_SHOWN: Final = 36
"""A longer status may be cut in its row, so it is also there for a pointer that rests on it."""
_STATES: Final = {
    "drive": "",
    "timeout": "no command",
    "rested": "resting",
    "paused": "paused",
    "taken": "",
    "stale": "stale: no recent pose",
}
_COLUMNS: Final = (
    '<colgroup><col><col style="width:40px"><col style="width:44px"><col style="width:50px"></colgroup>'
    "<tr><th>agent</th><th>speed<br>m/s</th>"
    '<th title="The smallest range that its sensors measure now."><u>nearest</u><br>m</th>'
    '<th title="How often it has touched a wall or another body."><u>contacts</u></th></tr>'
)
_KEY: Final = (
    f'<div class="iw-small">nearest: closest thing sensed, <span class="iw-near">red below {NEAR:g} m</span></div>'
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
    rows = "".join(_row(snapshot, entity, known.get(entity.name, Mark()), choices) for entity in shown)
    rest = len(bodies) - len(shown)
    more = f'<div class="iw-small">and {rest} more: use the list below</div>' if rest else ""
    old = "" if snapshot.phase == "live" else "iw-old"
    return block("agents", f"<table {handler}>{_COLUMNS}{rows}</table>{more}{_KEY}", classes=old)


def words(
    entity: Entity, body: Body | None, measures: Measures | None = None, *, here: bool = False, brief: bool = False
) -> str:
    """Return the status of a body in words.

    They say what it is if it is not simulated, who drives it, what its mind says that it does, why it does not drive,
    and whether its commands are slow.

    Args:
        entity: Its state.
        body: Its document.
        measures: Its newest measures, if they are known.
        here: Whether this page drives it.
        brief: Whether it must fit a row of the table.
    """
    said = []
    if body is not None and not _is_agent(body):
        said.append(f"{body.robot.kind}, placed")
    elif body is not None:
        reality = reality_of(body.robot)
        shown = reality_words(body.robot) if not brief or reality == "simulated" else reality
        said += [shown, driver_of(entity, body, measures, here=here)]
    if entity.mode:
        said.append(f"\u201c{entity.mode}\u201d")
    said.append(_STATES[entity.state])
    if entity.command_age:
        said.append(f"commands {number_format.decimal(entity.command_age)} s old")
    return ", ".join(filter(None, said))


def status_of(snapshot: Snapshot, entity: Entity, choices: Choices, *, brief: bool = False) -> str:
    """Return the status of a body in words, see `words`."""
    name, here = entity.name, choices.driven == entity.name
    return words(entity, snapshot.bodies.get(name), snapshot.measures.get(name), here=here, brief=brief)


def _is_agent(body: Body | None) -> bool:
    # A body that an operator placed has no instance that joined. In a playback no body has an owner.
    return body is None or body.owner is not None or body.robot.instance is not None


def _row(snapshot: Snapshot, entity: Entity, mark: Mark, choices: Choices) -> str:
    name, selected = html.escape(entity.name), choices.selected
    status = html.escape(status_of(snapshot, entity, choices, brief=True))
    touches = entity.contact or entity.collision
    whole = f' title="{status}"' if len(status) > _SHOWN else ""
    classes = " ".join(
        word for word, on in (("chosen", entity.name == selected), ("stale", entity.state == "stale")) if on
    )
    distance = nearest(snapshot, entity.name)
    near = "\u2013" if distance is None else number_format.decimal(distance)
    return (
        f'<tr class="{classes}" data-agent="{name}" data-testid="agent-{name}" data-state="{entity.state}">'
        f'<td><div class="iw-head">{swatch(mark)}<b class="iw-cut" title="{name}">{name}</b></div>'
        f'<div class="iw-small iw-wide{"" if touches else " iw-whole"}"{whole}>{status}</div></td>'
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
