"""The selected body: its motion, its sensor readings now and over time, its messages and events."""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Final

import viser

from intellwheels_schemas.messages import Entity
from intellwheels_viewer.panels import number_format, plots
from intellwheels_viewer.panels.agents import status_of
from intellwheels_viewer.panels.choices import Choices
from intellwheels_viewer.panels.event_lines import event_lines
from intellwheels_viewer.panels.events import event_item
from intellwheels_viewer.panels.marks import Mark, swatch
from intellwheels_viewer.panels.ranges import nearest
from intellwheels_viewer.panels.readings import Group, Row, groups
from intellwheels_viewer.panels.sparklines import WIDTH, sparkline
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block, note
from intellwheels_viewer.panels.style_sheet import figures as large
from intellwheels_viewer.snapshot import Snapshot

LOG: Final = 8
"""Lines of the list of messages and events."""


def head_html(snapshot: Snapshot, choices: Choices) -> str:
    """Return the name and the motion of the selected body, or a note if there is none or it has left."""
    if choices.selected is None:
        return block("selected", note("Nothing is selected. Click a chair."))
    entity = snapshot.entity(choices.selected)
    name = html.escape(choices.selected)
    if entity is None:
        return block("selected", note(f"{choices.selected} has left", "wait"))
    mark = Mark(*choices.looks.get(choices.selected, Mark()))
    distance = nearest(snapshot, choices.selected)
    return block(
        "selected",
        f'<div class="iw-head" data-selected="{name}">{swatch(mark)}<b class="iw-cut">{name}</b></div>'
        f'<div class="iw-small">{html.escape(status_of(snapshot, entity, choices))}</div>',
        large(
            (
                (number_format.decimal(entity.speed), "speed, m/s"),
                (number_format.degrees(entity.turn_rate), "turn, \u00b0/s"),
                ("\u2013" if distance is None else number_format.decimal(distance), "nearest, m"),
            )
        ),
        f'<div class="iw-small">{html.escape(_whereabouts(entity))}</div>',
    )


def sensors_html(snapshot: Snapshot, name: str) -> str:
    """Return all readings as numbers, grouped by kind of sensor."""
    measures = snapshot.measures.get(name)
    found = groups(measures) if measures is not None else []
    if not found:
        return block("sensors", '<span class="iw-soft">No sensor readings yet.</span>')
    charts = _charts(snapshot, name)
    return block("sensors", "".join(_group(group, charts if group.kind == "proximity" else {}) for group in found))


def log_html(snapshot: Snapshot, name: str) -> str:
    """Return a body's messages and events, newest first, at most `LOG` lines."""
    length = snapshot.period or 0.0
    about = [one for one in snapshot.events if name in {one.agent, one.other}]
    lines = [(line.event.tick * length, event_item(snapshot, line)) for line in event_lines(about, length)]
    lines += [(said.time, _said(said.time, said.text)) for said in snapshot.utterances if said.speaker == name]
    if not lines:
        return block("selected-log", f'<span class="iw-soft">No messages or events of {html.escape(name)} yet.</span>')
    newest = sorted(lines, key=lambda line: line[0], reverse=True)[:LOG]
    return block(
        "selected-log",
        '<div class="iw-caption">messages and events, time in s</div>',
        f'<ul class="iw-log">{"".join(line for _, line in newest)}</ul>',
    )


def _whereabouts(entity: Entity) -> str:
    heading = number_format.degrees(entity.heading)
    place = f"at {number_format.decimal(entity.x)}, {number_format.decimal(entity.y)} m, heading {heading}\u00b0"
    if entity.goal is None:
        return place
    return f"{place}, goal {number_format.decimal(entity.goal.x)}, {number_format.decimal(entity.goal.y)}"


def _charts(snapshot: Snapshot, name: str) -> dict[str, str]:
    """Return a chart for each proximity sensor of a body, by its id."""
    body, samples = snapshot.bodies.get(name), snapshot.history.get(name, ())
    sensors = body.robot.proximity if body is not None else ()
    top = max((one.max_range for one in sensors), default=1.0)
    return {one.id: chart for k, one in enumerate(sensors) if (chart := sparkline(samples, k, top))}


def _group(group: Group, charts: Mapping[str, str]) -> str:
    def cell(row: Row) -> str:
        # A word in place of a range is smaller: it must fit beside the chart.
        small = " iw-word" if charts and not row.tone else ""
        chart = f'<td class="iw-{row.tone or "soft"}">{charts.get(row.id, "")}</td>' if charts else ""
        return (
            f'<tr><td class="iw-cut" title="{html.escape(row.id)}">{html.escape(row.id)}</td>{chart}'
            f'<td class="iw-{row.tone or "ink"}{small}">{html.escape(row.text)}{_age(row.age)}</td></tr>'
        )

    rows = "".join(cell(row) for row in group.rows)
    # Short readings leave more room for the ids.
    share = 34 if max(len(row.text) for row in group.rows) > 12 else 55
    columns = f'<col><col style="width:{WIDTH + 8}px"><col style="width:76px">'
    if not charts:
        columns = f'<col style="width:{share}%"><col>'
    caption = html.escape(group.caption) + (", with the last 30 s" if charts else "")
    return (
        f'<div class="iw-group"><div class="iw-caption">{caption}</div>'
        f"<table><colgroup>{columns}</colgroup>{rows}</table></div>"
    )


def _age(ticks: int) -> str:
    return f'<div class="iw-small">{ticks} tick{"" if ticks == 1 else "s"} old</div>' if ticks else ""


def _said(time: float, text: str) -> str:
    return f"<li><span>{number_format.decimal(time)}</span><span>\u201c{html.escape(text)}\u201d</span></li>"


class SelectedPanel:
    """The selected body.

    Args:
        gui: Makes the elements, in the open container.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        gui.add_html(STYLE_SHEET)
        self._head = gui.add_html("")
        self._sensors = gui.add_html("", visible=False)
        self._speeds = _Chart(gui, "speed, m/s, over the last 30 s")
        self._log = gui.add_html("", visible=False)

    def show(self, snapshot: Snapshot, choices: Choices) -> None:
        """Show the selected body."""
        self._head.content = head_html(snapshot, choices)
        name = choices.selected
        here = name is not None and snapshot.entity(name) is not None
        self._sensors.visible = self._log.visible = here
        if name is None or not here:
            self._speeds.show(None)
            return
        samples, body = snapshot.history.get(name, ()), snapshot.bodies.get(name)
        self._speeds.show(plots.speeds(samples, body))
        self._sensors.content = sensors_html(snapshot, name)
        self._log.content = log_html(snapshot, name)


class _Chart:
    """A plot under its caption, hidden if there is nothing to plot."""

    def __init__(self, gui: viser.GuiApi, caption: str) -> None:
        self._caption = caption
        self._labels = gui.add_html("", visible=False)
        self._plot = gui.add_uplot(
            plots.NOTHING.data(),
            plots.NOTHING.series(),
            scales=plots.NOTHING.scales(),
            axes=plots.axes(),
            legend={"show": False},
            height=plots.HEIGHT,
            padding=plots.padding(),
            visible=False,
        )

    def show(self, plot: plots.Plot | None) -> None:
        self._labels.visible = self._plot.visible = plot is not None
        if plot is None:
            return
        self._labels.content = (
            f'<div class="iw" style="padding-bottom:0"><div class="iw-caption">{self._caption}</div></div>'
            f"{plots.label_html(plot)}"
        )
        # Assigning scales rebuilds the chart and resets its zoom, so assign only changes.
        if self._plot.scales != plot.scales():
            self._plot.scales = plot.scales()
        self._plot.data = plot.data()
