"""The events kept for late listeners. Pure.

A reply is bounded in bytes, so a listener that is far behind asks again from `Next` until nothing comes.
"""

from __future__ import annotations

from collections import deque
from itertools import islice
from typing import Final

import msgspec

from intellwheels_schemas.messages import Event, Events

KEPT: Final = 10_000
"""Events kept."""
REPLY_BYTES: Final = 48_000
"""One message stays under 60 kB: above it a healthy reader's wait grows a hundredfold."""


class EventBuffer:
    """The newest events of a run, numbered without gaps."""

    def __init__(self, kept: int = KEPT) -> None:
        self._events: deque[Event] = deque(maxlen=kept)
        self._run = ""

    def add(self, event: Event) -> None:
        """Keep an event; the first of a new run clears what was kept."""
        if event.run != self._run:
            self._events.clear()
            self._run = event.run
        self._events.append(event)

    def since(self, number: int, run: str) -> Events:
        """Return the kept events from a number on, as many as go into one message.

        `next` is the number to ask from the next time.
        """
        events = self._events if run == self._run else deque[Event]()
        oldest = events[0].number if events else 0
        following = events[-1].number + 1 if events else 0
        first = max(number - oldest, 0)
        chosen: list[Event] = []
        size = 0
        for event in islice(events, first, None):
            size += len(msgspec.json.encode(event)) + 1
            if chosen and size > REPLY_BYTES:
                break
            chosen.append(event)
        if chosen:
            following = chosen[-1].number + 1
        return Events(run=run, oldest=oldest, next=following, event=tuple(chosen))
