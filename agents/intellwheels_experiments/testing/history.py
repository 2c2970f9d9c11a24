"""All that was seen of a run, moment by moment. Pure: messages in, moments out.

A moment is whole: every part of a tick's state, and the events until then. Parts of different ticks are never mixed;
a tick of which a part was lost is no moment.
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
    """A body that is looked for is not there."""


class Point(NamedTuple):
    """Where a body's centre of movement was.

    Attributes:
        time: Simulated seconds since the run began.
        x, y: In m, in the map's frame.
        heading: In rad, in (-pi, pi].
    """

    time: float
    x: float
    y: float
    heading: float


@dataclass(frozen=True, slots=True)
class Moment:
    """The world at a tick; `moment["chair1"]` is a body's state.

    Attributes:
        tick: Steps since the run began.
        time: Simulated seconds since then.
        bodies: True states by name.
        events: What happened until then, in order.
    """

    tick: int
    time: float
    bodies: Mapping[str, Entity]
    events: tuple[Event, ...]

    def __getitem__(self, name: str) -> Entity:
        """Return a body's true state: `x`, `y` (m), `heading` (rad), `speed` (m/s), `contacts` and so on.

        Raises:
            AbsentError: It is not there.
        """
        if name not in self.bodies:
            there = ", ".join(self.bodies) or "nobody"
            raise AbsentError(f"tick {self.tick}: expected a body that is there ({there}), got {name!r}")
        return self.bodies[name]

    def happened(self, code: EventCode, agent: str | None = None) -> bool:
        """Return whether there was such an event, of that agent if one is named."""
        return any(event.code == code and agent in (None, event.agent) for event in self.events)

    @property
    def contacts(self) -> list[tuple[str, str]]:
        """Who touched whom, in order: two bodies, or a body and `wall`."""
        return [(event.agent or "", event.other or "") for event in self.events if event.code == "contact"]

    def describe(self, events: int = 5) -> str:
        """Return the moment in words, a line for each body and for each of the last events."""
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
    """The record of the newest run with every moment of it.

    Attributes:
        newest: The newest moment, or None before the first.
        fresh: Moments that nobody took yet, the oldest first.
        paths: Where each body was, by name.
    """

    def __init__(self) -> None:
        super().__init__()
        self.newest: Moment | None = None
        self.fresh: deque[Moment] = deque()
        self.paths: dict[str, list[Point]] = {}
        self._parts: dict[int, WorldState] = {}
        self._shown: str | None = None
        self._told: tuple[Event, ...] = ()

    def on_state(self, state: WorldState) -> None:
        """Take a part of the state; with the last part of its tick it becomes a moment."""
        super().on_state(state)
        if state.run != self.run:
            return
        if self._shown != self.run:
            self._shown = self.run
            self.newest = None
            self._parts.clear()
            self.paths.clear()
            self.fresh.clear()
        last = max([part.tick for part in self._parts.values()], default=-1)
        if state.tick < max(last, self.newest.tick if self.newest else -1):
            return
        if state.tick > last or any(part.parts != state.parts for part in self._parts.values()):
            self._parts.clear()
        self._parts[state.part] = state
        if len(self._parts) == state.parts:
            self._show(state)
            self._parts.clear()

    def _show(self, state: WorldState) -> None:
        bodies = {entity.name: entity for number in sorted(self._parts) for entity in self._parts[number].entity}
        self.newest = Moment(state.tick, state.time, bodies, self._events_so_far())
        self.fresh.append(self.newest)
        for name, body in bodies.items():
            path = self.paths.setdefault(name, [])
            point = Point(state.time, body.x, body.y, body.heading)
            # While a run stands a body may be put elsewhere: the later of equals counts.
            if path and path[-1].time == point.time:
                path[-1] = point
            else:
                path.append(point)

    def _events_so_far(self) -> tuple[Event, ...]:
        if len(self._told) != len(self.events) or (self._told and self._told[0].run != self.run):
            self._told = tuple(self.events[number] for number in sorted(self.events))
        return self._told
