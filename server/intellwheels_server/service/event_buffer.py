"""The newest events of a run, for subscribers that come late. Pure.

A reply has a limited size. A reader that is far behind repeats the query from `Next` until no event comes.
"""

from __future__ import annotations

from collections import deque
from itertools import islice
from typing import Final

import msgspec

from intellwheels_schemas.messages import Event, Events

CAPACITY: Final = 10_000
"""Events kept."""
REPLY_BYTES: Final = 48_000
"""Size of a reply as JSON: messages above 60 kB delay a healthy reader a hundredfold."""


class EventBuffer:
    """The newest events of a run, numbered without gaps.

    Args:
        capacity: Events kept.
    """

    def __init__(self, capacity: int = CAPACITY) -> None:
        self._events: deque[Event] = deque(maxlen=capacity)
        self._run = ""

    def add(self, event: Event) -> None:
        """Add an event; the first event of another run removes all earlier ones."""
        if event.run != self._run:
            self._events.clear()
            self._run = event.run
        self._events.append(event)

    def since(self, number: int, run: str) -> Events:
        """Return the events of a run from a number on, as many as fit into one message.

        `next` is the number at which the next query must begin.
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
