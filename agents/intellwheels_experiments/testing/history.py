"""Everything that was seen of a run, moment by moment. Pure: messages in, moments out.

A moment is complete: it has every part of a tick's state, and the events up to then. Parts of different ticks are never
mixed, and a tick that misses a part gives no moment.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_schemas.messages import Entity, Event, EventCode, WorldState


class AbsentError(LookupError):
    """A body was looked up that is not in the world."""


class Point(NamedTuple):
    """The pose of a body's centre of movement at a time.

    Attributes:
        time: Simulated time since the start of the run, in s.
        x: In m, in the map's frame.
        y: In m, in the map's frame.
        heading: In rad, in (-pi, pi], anticlockwise from the x axis.
    """

    time: float
    x: float
    y: float
    heading: float


@dataclass(frozen=True, slots=True)
class Moment:
    """The world at a tick. `moment["chair1"]` is the state of a body.

    Attributes:
        tick: Number of ticks since the start of the run.
        time: Simulated time since then, in s.
        bodies: The true states of the bodies, by name.
        events: The events up to then, in order.
    """

    tick: int
    time: float
    bodies: Mapping[str, Entity]
    events: tuple[Event, ...]

    def __getitem__(self, name: str) -> Entity:
        """Return a body's true state.

        Its fields are `x` and `y` in m, `heading` in rad, `speed` in m/s, `contacts` and the others of `Entity` in
        `intellwheels_schemas.messages`.

        Raises:
            AbsentError: There is no such body.
        """
        if name not in self.bodies:
            present = ", ".join(self.bodies) or "none"
            raise AbsentError(f"tick {self.tick}: expected one of the bodies present ({present}), got {name!r}")
        return self.bodies[name]

    def happened(self, code: EventCode, agent: str | None = None) -> bool:
        """Return whether an event of this code happened until now; if `agent` is given, one about that agent."""
        return any(event.code == code and agent in (None, event.agent) for event in self.events)

    @property
    def contacts(self) -> list[tuple[str, str]]:
        """The pairs that came into contact until now, in order: two bodies, or a body and `wall`."""
        return [(event.agent or "", event.other or "") for event in self.events if event.code == "contact"]

    def describe(self, events: int = 5) -> str:
        """Return the moment as text: one line per body, and one for each of the last `events` events."""
        lines = [f"tick {self.tick}, {self.time:.2f} s"]
        lines += [
            f"  {body.name}: x {body.x:.3f} y {body.y:.3f} heading {math.degrees(body.heading):.1f} deg "
            f"speed {body.speed:.3f} contacts {body.contacts} {body.state}"
            for body in self.bodies.values()
        ]
        lines += [
            f"  event: tick {event.tick} {event.code} {event.agent or ''} {event.other or event.text or ''}".rstrip()
            for event in self.events[-events:]
        ]
        return "\n".join(lines)


class History(RunRecord):
    """The record of the newest run, with all its moments.

    Attributes:
        newest: The newest moment, or None before the first.
        unread: Moments that were not taken yet, the oldest first.
        paths: The poses of each body over time, by name.
    """

    def __init__(self) -> None:
        super().__init__()
        self.newest: Moment | None = None
        self.unread: deque[Moment] = deque()
        self.paths: dict[str, list[Point]] = {}
        self._parts: dict[int, WorldState] = {}
        self._moments_of: str | None = None
        self._sorted_events: tuple[Event, ...] = ()

    def on_state(self, state: WorldState) -> None:
        """Add a part of the state. The last part of a tick completes a moment."""
        super().on_state(state)
        if state.run != self.run:
            return
        if self._moments_of != self.run:
            self._moments_of = self.run
            self.newest = None
            self._parts.clear()
            self.paths.clear()
            self.unread.clear()
        last = max([part.tick for part in self._parts.values()], default=-1)
        if state.tick < max(last, self.newest.tick if self.newest else -1):
            return
        if state.tick > last or any(part.parts != state.parts for part in self._parts.values()):
            self._parts.clear()
        self._parts[state.part] = state
        if len(self._parts) == state.parts:
            self._complete(state)
            self._parts.clear()

    def _complete(self, state: WorldState) -> None:
        bodies = {entity.name: entity for number in sorted(self._parts) for entity in self._parts[number].entity}
        self.newest = Moment(state.tick, state.time, bodies, self._events_so_far())
        self.unread.append(self.newest)
        for name, body in bodies.items():
            path = self.paths.setdefault(name, [])
            point = Point(state.time, body.x, body.y, body.heading)
            # While the run is paused a body may be moved: of equal times the last pose counts.
            if path and path[-1].time == point.time:
                path[-1] = point
            else:
                path.append(point)

    def _events_so_far(self) -> tuple[Event, ...]:
        """Return the events in order. The tuple is kept until there is a new event or a new run."""
        kept = self._sorted_events
        if len(kept) != len(self.events) or (kept and kept[0].run != self.run):
            self._sorted_events = tuple(self.events[number] for number in sorted(self.events))
        return self._sorted_events
