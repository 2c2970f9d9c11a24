"""What was seen of a run: clocks, states and events become tracks. Pure: messages in, no network, no time.

Messages come in any order and some are lost; order is (Run, Tick), events are numbered. A new
run clears what was known of the last, and what comes late from a past run is dropped.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from intellwheels_schemas.messages import Clock, Entity, Event, Events, WorldState

EVENT_LIMIT: Final = 100_000
"""Events kept: a run with more is counted on, its later ones are not kept."""


@dataclass(slots=True)
class Track:
    """What was seen of one body.

    Attributes:
        first: Its state when first seen.
        last: Its state when last seen.
        tick: When last seen.
        length: Sum of the straight stretches between the states seen, in m: a lower bound of its path.
        turned: Greatest angle seen between its heading and its first one, in rad, in [0, pi].
    """

    first: Entity
    last: Entity
    tick: int
    length: float = 0.0
    turned: float = 0.0

    def follow(self, entity: Entity, tick: int) -> None:
        """Take a later state; an older one changes nothing."""
        if tick <= self.tick:
            return
        self.length += math.hypot(entity.x - self.last.x, entity.y - self.last.y)
        self.turned = max(self.turned, abs(math.remainder(entity.heading - self.first.heading, math.tau)))
        self.last = entity
        self.tick = tick


@dataclass(slots=True)
class RunRecord:
    """What was seen of the newest run.

    Attributes:
        run: The run, or None when nothing was seen yet.
        clock: Its newest clock.
        tracks: By body.
        events: By number.
        counts: Number of events by code.
        ended: The event that ended the run.
    """

    run: str | None = None
    clock: Clock | None = None
    tracks: dict[str, Track] = field(default_factory=dict)
    events: dict[int, Event] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    ended: Event | None = None
    _past: set[str] = field(default_factory=set)
    _next: int = 0

    def on_clock(self, clock: Clock) -> None:
        """Take a clock."""
        # While a run waits or is paused its tick stands and its state changes: the later of equals counts.
        if self._is_current(clock.run) and (
            self.clock is None or (clock.tick, clock.stamp) >= (self.clock.tick, self.clock.stamp)
        ):
            self.clock = clock

    def on_state(self, state: WorldState) -> None:
        """Take a part of the state."""
        if not self._is_current(state.run):
            return
        for entity in state.entity:
            track = self.tracks.get(entity.name)
            if track is None:
                self.tracks[entity.name] = Track(entity, entity, state.tick)
            else:
                track.follow(entity, state.tick)

    def on_event(self, event: Event) -> None:
        """Take an event, once by its number."""
        if not self._is_current(event.run):
            return
        self._next = max(self._next, event.number + 1)
        if event.number in self.events or len(self.events) >= EVENT_LIMIT:
            return
        self.events[event.number] = event
        self.counts[event.code] = self.counts.get(event.code, 0) + 1
        if event.code == "ended":
            self.ended = event

    def on_events(self, events: Events) -> None:
        """Take the simulator's own list of events."""
        if self._is_current(events.run):
            self._next = max(self._next, events.next)
            for event in events.event:
                self.on_event(event)

    @property
    def wanted(self) -> int:
        """The lowest number of an event that was not seen."""
        if len(self.events) == self._next:
            return self._next
        return next(number for number in range(self._next) if number not in self.events)

    def positions(self) -> Mapping[str, tuple[float, float]]:
        """Return where each body was last seen, in m."""
        return {name: (track.last.x, track.last.y) for name, track in self.tracks.items()}

    def _is_current(self, run: str) -> bool:
        if run == self.run:
            return True
        if run in self._past:
            return False
        if self.run is not None:
            self._past.add(self.run)
        self.run = run
        self.clock = self.ended = None
        self._next = 0
        for known in (self.tracks, self.events, self.counts):
            known.clear()
        return True
