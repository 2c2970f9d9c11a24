"""The events of the run in words with their times, newest first. Contacts are red; a line separates runs."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from typing import Final

import viser

from intellwheels_schemas.messages import Event
from intellwheels_viewer.panels import number_format
from intellwheels_viewer.panels.sentences import sentence
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block
from intellwheels_viewer.snapshot import USER, Snapshot, Utterance

SHOWN: Final = 100


def events_html(snapshot: Snapshot) -> str:
    """Return the newest events as a list."""
    speech = [each for each in snapshot.utterances if each.speaker == USER]
    if not snapshot.events and not speech:
        return block("events", '<span class="iw-soft">Nothing has happened yet.</span>')
    newest = snapshot.events[::-1][:SHOWN]
    older = len(snapshot.events) - len(newest)
    more = f'<div class="iw-small">and {older} older</div>' if older else ""
    return block(
        "events",
        '<div class="iw-caption">time, s</div>',
        f'<ul class="iw-log">{"".join(_items(snapshot, newest, speech[::-1]))}</ul>',
        more,
    )


def event_item(snapshot: Snapshot, event: Event) -> str:
    """Return an event as a list item: its time and its sentence."""
    red = ' class="iw-red"' if event.code == "contact" else ""
    return (
        f'<li data-code="{event.code}" data-number="{event.number}">'
        f"<span>{number_format.moment(event.tick, snapshot)}</span>"
        f"<span{red}>{html.escape(sentence(event))}</span></li>"
    )


def speech_item(utterance: Utterance) -> str:
    """Return what a user said as a list item: its time and a sentence."""
    to = "everybody" if utterance.to is None else utterance.to
    sentence = html.escape(f"A user said to {to}: \u201c{utterance.text}\u201d")
    return f'<li data-code="said"><span>{number_format.decimal(utterance.time)}</span><span>{sentence}</span></li>'


def _items(snapshot: Snapshot, newest: Iterable[Event], speech: Sequence[Utterance]) -> Iterable[str]:
    run, period, waiting = None, snapshot.period or 0.0, list(speech)
    for event in newest:
        while waiting and (event.run != snapshot.run or waiting[0].time >= event.tick * period):
            yield speech_item(waiting.pop(0))
        if run is not None and event.run != run:
            yield '<li class="break">previous run</li>'
        run = event.run
        yield event_item(snapshot, event)
    yield from (speech_item(utterance) for utterance in waiting)


class EventsPanel:
    """The list of events.

    Args:
        gui: Makes the elements, in the open container.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        gui.add_html(STYLE_SHEET)
        self._list = gui.add_html("")

    def show(self, snapshot: Snapshot) -> None:
        """Show the events of a snapshot."""
        self._list.content = events_html(snapshot)
