"""A snapshot of a run: the newest value of everything that the simulator published.

`StateStore` makes snapshots from messages. A `Snapshot` is immutable, so any thread may keep and read it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

from intellwheels_schemas.messages import Body, Clock, Entity, Event, Identity, Map, Measures, Pose

Phase = Literal["no-router", "no-world", "choose", "live", "silent", "gone"]
"""State of the connection to a world.

`no-router`: nothing answers at the endpoint. `no-world`: no simulator runs there. `choose`: several worlds run and none
is chosen. `live`: the world is running. `silent`: its liveliness token exists, but no clock came for 3 s. `gone`: its
token disappeared.
"""

EVENTS_KEPT: Final = 500
USER: Final = "operator"
"""The speaker of what a user says in a page. No agent can have this name."""
HISTORY: Final = 30.0
"""Simulated seconds of measures and speeds that are kept for plots."""
TRAIL: Final = 20.0
"""Length of the trail behind an agent, in the scene and on the plan, in simulated seconds."""


@dataclass(frozen=True)
class Sample:
    """An agent's state at one time, for plots and trails. SI units."""

    time: float
    x: float
    y: float
    heading: float
    speed: float
    ranges: tuple[float | None, ...] = ()


@dataclass(frozen=True)
class Utterance:
    """An utterance.

    Attributes:
        speaker: An agent, or `USER`.
        time: In simulated seconds.
        text: What was said.
        to: The agent that a user spoke to; None for everybody. Agents speak to everybody.
    """

    speaker: str
    time: float
    text: str
    to: str | None = None


@dataclass(frozen=True)
class Snapshot:
    """A run at one moment.

    Attributes:
        phase: State of the connection.
        world: Its name; empty while none is chosen.
        worlds: The names of all running worlds, sorted.
        endpoint: Where the viewer looks for worlds.
        run, tick, time: Of the newest state; time in simulated seconds.
        clock, floor, bodies, entities: The newest of each. Bodies are by agent, entities in the order of the state.
        revision: Number of the map, counted by the viewer. It changes with the map.
        events: The newest, oldest first, at most `EVENTS_KEPT`.
        measures: By agent, for agents whose measures are subscribed.
        reported: In a playback, the poses that bridges reported for their real chairs at this tick, by agent. Empty
            otherwise.
        utterances: What was said in this run, newest last, at most `EVENTS_KEPT`.
        history: Samples of the last `HISTORY` simulated seconds by agent, oldest first.
        last_tick: The last tick of the log in a playback; None in a live run.
        rights: What this viewer may do by the rules of the router; None if nobody knows.
        version: Changes whenever the scene must be redrawn: with states, bodies, maps and events. The tick cannot be
            used for this, as bodies can be moved while a run is paused.
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
    utterances: tuple[Utterance, ...] = ()
    history: Mapping[str, tuple[Sample, ...]] = field(default_factory=dict)
    last_tick: int | None = None
    rights: Identity | None = None
    version: int = 0

    @property
    def period(self) -> float | None:
        """The simulated seconds of a tick; None before the first tick."""
        if self.clock is not None and self.clock.tick:
            return self.clock.time / self.clock.tick
        return self.time / self.tick if self.tick else None

    @property
    def is_over(self) -> bool:
        """Whether a live run has met its end condition."""
        return self.clock is not None and self.clock.state == "ended" and self.last_tick is None

    @property
    def judged(self) -> float | None:
        """The simulated seconds at which the end condition of this run was met, if it went on since then."""
        if self.clock is None or (self.clock.state == "ended" and self.last_tick is None):
            return None
        ends = [event.tick for event in self.events if event.code == "ended" and event.run == self.run]
        return ends[-1] * (self.period or 0.0) if ends and ends[-1] < self.tick else None

    @property
    def stale(self) -> frozenset[str]:
        """The real chairs whose pose is out of date. They are still obstacles."""
        return frozenset(entity.name for entity in self.entities if entity.state == "stale")

    def entity(self, name: str) -> Entity | None:
        """Return an agent's state, or None if it is not there."""
        return next((entity for entity in self.entities if entity.name == name), None)
