"""The run's events, newest first, in words with their times. A contact is red; another run begins below a line."""

from __future__ import annotations

import html
from collections.abc import Iterable
from typing import Final

import viser

from intellwheels_schemas.messages import Event
from intellwheels_viewer.panels import number_format
from intellwheels_viewer.panels.sentences import sentence
from intellwheels_viewer.panels.style_sheet import STYLE_SHEET, block
from intellwheels_viewer.snapshot import Snapshot

SHOWN: Final = 100


def events_html(seen: Snapshot) -> str:
    """Return the list of the newest events."""
    if not seen.events:
        return block("events", '<span class="iw-soft">Nothing has happened yet.</span>')
    newest = seen.events[::-1][:SHOWN]
    older = len(seen.events) - len(newest)
    more = f'<div class="iw-small">and {older} older</div>' if older else ""
    return block(
        "events",
        '<div class="iw-caption">time, s</div>',
        f'<ul class="iw-log">{"".join(_items(seen, newest))}</ul>',
        more,
    )


def event_item(seen: Snapshot, event: Event) -> str:
    """Return a line of a list: time and sentence."""
    red = ' class="iw-red"' if event.code == "contact" else ""
    return (
        f'<li data-code="{event.code}" data-number="{event.number}">'
        f"<span>{number_format.moment(event.tick, seen)}</span>"
        f"<span{red}>{html.escape(sentence(event))}</span></li>"
    )


def _items(seen: Snapshot, newest: Iterable[Event]) -> Iterable[str]:
    run = None
    for event in newest:
        if run is not None and event.run != run:
            yield '<li class="break">the run before</li>'
        run = event.run
        yield event_item(seen, event)


class EventsPanel:
    """The list of events.

    Args:
        gui: Where the element is made, in the container that is open.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        gui.add_html(STYLE_SHEET)
        self._list = gui.add_html("")

    def show(self, seen: Snapshot) -> None:
        """Show the events; costs nothing while none is new."""
        self._list.content = events_html(seen)
