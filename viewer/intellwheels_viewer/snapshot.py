"""What the viewer knows of a run: the newest of everything the simulator said. Pure, and nothing a restart could lose.

Messages are folded in as they come, by one thread; `Snapshot` is a value that others may keep and read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

from intellwheels_schemas.messages import Body, Clock, Entity, Event, Map, Measures, Pose

Phase = Literal["no-router", "no-world", "choose", "live", "silent", "gone"]
"""Whether there is something to see.

`no-router`: nobody at the endpoint; `no-world`: no simulator there; `choose`: several worlds and none chosen; `live`;
`silent`: its token is there, but no clock for 3 s; `gone`: it was there, and its token went.
"""

EVENTS_KEPT: Final = 500
HISTORY: Final = 30.0
"""Simulated seconds of which measures and speeds are kept for plots."""


@dataclass(frozen=True)
class Sample:
    """An agent at a moment: what plots and trails are drawn from."""

    time: float
    x: float
    y: float
    heading: float
    speed: float
    ranges: tuple[float | None, ...] = ()


@dataclass(frozen=True)
class Words:
    """Something that was said, and when."""

    speaker: str
    time: float
    text: str


@dataclass(frozen=True)
class Snapshot:
    """A run as it is known.

    Attributes:
        phase: Whether there is a world to see.
        world: Its name; empty while none is chosen.
        worlds: The names of all worlds that are there, sorted.
        endpoint: Where the viewer looks for them.
        run, tick, time: Of the newest state, in seconds.
        clock, floor, bodies, entities: The newest of each; bodies by agent, entities in the order of the state.
        revision: Of the floor, counted by the viewer; another floor has another.
        events: The newest, oldest first, at most `EVENTS_KEPT`.
        measures: By agent, of those whose measures are watched.
        reported: In a log that is played, where bridges said that their real chairs were at this tick, by agent; empty
            where nobody tells.
        words: What was said in this run, newest last, at most `EVENTS_KEPT`.
        history: Of each agent the last `HISTORY` simulated seconds, oldest first.
        last_tick: The last tick of the log when this world plays one, else None.
        version: Counts what is worth a drawing: states, bodies, floors, events. A tick does not tell: bodies are moved
            while a run is paused.
    """

    phase: Phase = "no-router"
    world: str = ""
    worlds: tuple[str, ...] = ()
    endpoint: str = ""
    run: str = ""
    tick: int = 0
    time: float = 0.0
    clock: Clock | None = None
    floor: Map | None = None
    revision: int = -1
    bodies: Mapping[str, Body] = field(default_factory=dict)
    entities: tuple[Entity, ...] = ()
    events: tuple[Event, ...] = ()
    measures: Mapping[str, Measures] = field(default_factory=dict)
    reported: Mapping[str, Pose] = field(default_factory=dict)
    words: tuple[Words, ...] = ()
    history: Mapping[str, tuple[Sample, ...]] = field(default_factory=dict)
    last_tick: int | None = None
    version: int = 0

    @property
    def stale(self) -> frozenset[str]:
        """The real chairs whose pose is old; they are still obstacles."""
        return frozenset(entity.name for entity in self.entities if entity.state == "stale")

    def entity(self, name: str) -> Entity | None:
        """Return an agent's state, None when it is not there."""
        return next((entity for entity in self.entities if entity.name == name), None)
