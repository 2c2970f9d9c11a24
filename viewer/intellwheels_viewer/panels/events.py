"""The events of the run in words with their times, newest first. Contacts are red; a line separates runs."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from typing import Final

import viser

from intellwheels_viewer.panels import number_format
from intellwheels_viewer.panels.event_lines import EventLine, event_lines, kind_of
from intellwheels_viewer.panels.segments import Segments
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block
from intellwheels_viewer.snapshot import USER, Snapshot, Utterance

SHOWN: Final = 100
ALL: Final = "All"
FILTERS: Final = (ALL, "Contacts", "Agents", "Run", "Words")
"""What the list can be limited to. `Words` are what users said from this viewer."""


def events_html(snapshot: Snapshot, only: str = ALL) -> str:
    """Return the newest events as a list: all, or only those of one of `FILTERS`."""
    speech = [each for each in snapshot.utterances if each.speaker == USER and only in (ALL, "Words")]
    events = [event for event in snapshot.events if only in (ALL, kind_of(event))]
    if not events and not speech:
        nothing = "Nothing has happened yet." if only == ALL else f"{only}: nothing yet."
        return block("events", f'<span class="iw-soft">{nothing}</span>')
    lines = event_lines(events, snapshot.period or 0.0)
    newest = lines[:SHOWN]
    older = len(lines) - len(newest)
    more = f'<div class="iw-small">and {older} older</div>' if older else ""
    return block(
        "events",
        '<div class="iw-caption">time, s</div>',
        f'<ul class="iw-log">{"".join(_items(snapshot, newest, speech[::-1]))}</ul>',
        more,
    )


def event_item(snapshot: Snapshot, line: EventLine) -> str:
    """Return a line as a list item: its time and its sentence."""
    event = line.event
    red = ' class="iw-red"' if event.code == "contact" else ""
    return (
        f'<li data-code="{event.code}" data-number="{event.number}" data-count="{line.count}">'
        f"<span>{number_format.moment(event.tick, snapshot)}</span>"
        f"<span{red}>{html.escape(line.text)}</span></li>"
    )


def speech_item(utterance: Utterance) -> str:
    """Return what a user said as a list item: its time and a sentence."""
    to = "everybody" if utterance.to is None else utterance.to
    sentence = html.escape(f"A user said to {to}: \u201c{utterance.text}\u201d")
    return f'<li data-code="said"><span>{number_format.decimal(utterance.time)}</span><span>{sentence}</span></li>'


def _items(snapshot: Snapshot, newest: Iterable[EventLine], speech: Sequence[Utterance]) -> Iterable[str]:
    run, period, waiting = None, snapshot.period or 0.0, list(speech)
    for line in newest:
        event = line.event
        while waiting and (event.run != snapshot.run or waiting[0].time >= event.tick * period):
            yield speech_item(waiting.pop(0))
        if run is not None and event.run != run:
            yield '<li class="break">previous run</li>'
        run = event.run
        yield event_item(snapshot, line)
    yield from (speech_item(utterance) for utterance in waiting)


class EventsPanel:
    """The list of events and its filter.

    Args:
        gui: Makes the elements, in the open container.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        gui.add_html(STYLE_SHEET)
        self._only = ALL
        self._filter = Segments(gui, "Events", FILTERS, self._limit)
        self._filter.show(ALL)
        self._list = gui.add_html("")
        self._shown = Snapshot()

    def show(self, snapshot: Snapshot) -> None:
        """Show the events of a snapshot."""
        self._shown = snapshot
        self._list.content = events_html(snapshot, self._only)

    def _limit(self, only: str) -> None:
        self._only = only
        self._filter.show(only)
        self.show(self._shown)
