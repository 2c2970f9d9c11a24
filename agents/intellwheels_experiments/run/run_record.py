"""The record of a run, made from its clock, state and event messages. Pure: no network, no clock.

Messages arrive in any order and some are lost. States are ordered by (Run, Tick), events by their number. A new run
clears the record, and late messages of an earlier run are dropped.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from intellwheels_schemas.messages import Clock, Entity, Event, Events, WorldState

EVENT_LIMIT: Final = 100_000
"""Events stored. Later events of a run are neither stored nor counted."""


@dataclass(slots=True)
class Track:
    """The record of one body.

    Attributes:
        first: Its state when first seen.
        last: Its state when last seen.
        tick: When last seen.
        length: Length of its path, in m: the simulator's sum over all ticks. If the state has none, the sum of the
            straight distances between the states seen, a lower bound.
        turned: Largest angle between its heading and its first one, in rad, in [0, pi]: the simulator's. If the state
            has none, the largest seen.
    """

    first: Entity
    last: Entity
    tick: int
    length: float = 0.0
    turned: float = 0.0

    def follow(self, entity: Entity, tick: int) -> None:
        """Add a state. One that is not newer than the last changes nothing."""
        if tick <= self.tick:
            return
        seen = math.hypot(entity.x - self.last.x, entity.y - self.last.y)
        self.length = self.length + seen if entity.travelled is None else entity.travelled
        angle = abs(math.remainder(entity.heading - self.first.heading, math.tau))
        self.turned = max(self.turned, angle) if entity.turned is None else entity.turned
        self.last = entity
        self.tick = tick


@dataclass(slots=True)
class RunRecord:
    """The record of the newest run.

    Attributes:
        run: The run's id, or None before the first message.
        clock: Its newest clock message.
        tracks: The tracks by body.
        events: The events by number.
        counts: The number of events by code.
        ended: The event that ended the run, or None.
    """

    run: str | None = None
    clock: Clock | None = None
    tracks: dict[str, Track] = field(default_factory=dict)
    events: dict[int, Event] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    ended: Event | None = None
    _past_runs: set[str] = field(default_factory=set)
    _next_event: int = 0

    def on_clock(self, clock: Clock) -> None:
        """Add a clock message."""
        # While a run waits or is paused, its tick stays and its state changes: of equal ticks the newest stamp counts.
        if self._is_current(clock.run) and (
            self.clock is None or (clock.tick, clock.stamp) >= (self.clock.tick, self.clock.stamp)
        ):
            self.clock = clock

    def on_state(self, state: WorldState) -> None:
        """Add a part of the state."""
        if not self._is_current(state.run):
            return
        for entity in state.entity:
            track = self.tracks.get(entity.name)
            if track is None:
                length, turned = entity.travelled or 0.0, entity.turned or 0.0
                self.tracks[entity.name] = Track(entity, entity, state.tick, length, turned)
            else:
                track.follow(entity, state.tick)

    def on_event(self, event: Event) -> None:
        """Add an event, unless its number is known."""
        if not self._is_current(event.run):
            return
        self._next_event = max(self._next_event, event.number + 1)
        if event.number in self.events or len(self.events) >= EVENT_LIMIT:
            return
        self.events[event.number] = event
        self.counts[event.code] = self.counts.get(event.code, 0) + 1
        if event.code == "ended":
            self.ended = event

    def on_events(self, events: Events) -> None:
        """Add the simulator's own list of events."""
        if self._is_current(events.run):
            self._next_event = max(self._next_event, events.next)
            for event in events.event:
                self.on_event(event)

    @property
    def next_missing(self) -> int:
        """The lowest number of an event that was not seen."""
        if len(self.events) == self._next_event:
            return self._next_event
        return next(number for number in range(self._next_event) if number not in self.events)

    def positions(self) -> Mapping[str, tuple[float, float]]:
        """Return where each body was last seen, in m."""
        return {name: (track.last.x, track.last.y) for name, track in self.tracks.items()}

    def _is_current(self, run: str) -> bool:
        if run == self.run:
            return True
        if run in self._past_runs:
            return False
        if self.run is not None:
            self._past_runs.add(self.run)
        self.run = run
        self.clock = self.ended = None
        self._next_event = 0
        for of_run in (self.tracks, self.events, self.counts):
            of_run.clear()
        return True
