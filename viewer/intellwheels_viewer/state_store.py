"""The state store: takes messages, returns a `Snapshot`. Pure, on one thread.

Messages may be lost or arrive out of order. A new run replaces the old one. An older tick of the same run is ignored,
except in a playback, where it means that a user moved the position back.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from typing import Final

from intellwheels_schemas.messages import Body, Clock, Entity, Event, Events, Map, MapInfo, Measures, Pose, WorldState
from intellwheels_viewer.reported_speed import ReportedSpeeds
from intellwheels_viewer.snapshot import EVENTS_KEPT, HISTORY, USER, Phase, Sample, Snapshot, Utterance

SAMPLES_A_SECOND: Final = 10
"""Samples kept of the history; more would not be visible."""
NEAR: Final = 2
"""Largest number of ticks between a reported pose and the state with which it is shown; they arrive in turn."""
RUNS_KNOWN: Final = 16
"""Past runs that are remembered, so that their late messages are recognised."""
RETURNS: Final = 1.0
"""Seconds by which the clock of a past run must be newer before that run becomes current again.

A late clock of a past run is older. This covers a foreign message that named another run."""


class StateStore:
    """The newest messages of one world.

    Attributes:
        wants_events_since: The number of the oldest missing event; None if none is missing.
    """

    def __init__(self) -> None:
        self._run = ""
        self._past: deque[str] = deque(maxlen=RUNS_KNOWN)
        self._clock: Clock | None = None
        self._floor: Map | None = None
        self._info: MapInfo | None = None
        self._floor_of = ("", "")
        self._revision = -1
        self._bodies: dict[str, Body] = {}
        self._parts: dict[int, WorldState] = {}
        self._state_at = (-1, 0.0)
        self._entities: tuple[Entity, ...] = ()
        self._events: dict[int, Event] = {}
        self._next_event = 0
        self._measures: dict[str, Measures] = {}
        self._reported: dict[str, Pose] = {}
        self._utterances: deque[Utterance] = deque(maxlen=EVENTS_KEPT)
        self._saying: dict[str, str] = {}
        self._speeds = ReportedSpeeds()
        self._history: dict[str, deque[Sample]] = {}
        self._history_cache: Mapping[str, tuple[Sample, ...]] | None = None  # valid until the state changes
        self._stamp = 0.0
        self._version = 0
        self.wants_events_since: int | None = None

    @property
    def map_in_use(self) -> tuple[str, str]:
        """The run and the hash of its map; empty while unknown."""
        return self._run, "" if self._info is None else self._info.hash

    @property
    def map_is_missing(self) -> bool:
        """Whether the current map is unknown."""
        return bool(self._run) and self._floor_of != self.map_in_use

    @property
    def bodies(self) -> Mapping[str, Body]:
        """The known bodies, by name."""
        return self._bodies

    @property
    def missing_bodies(self) -> frozenset[str]:
        """The agents in the state whose bodies are unknown."""
        return frozenset(entity.name for entity in self._entities) - self._bodies.keys()

    # ------------------------------------------------------------ messages in

    def on_clock(self, clock: Clock) -> None:
        """Take a clock. A clearly newer clock of a past run makes that run the current one again."""
        if clock.run in self._past and clock.stamp > self._stamp + RETURNS:
            self._past.remove(clock.run)
        if self._is_current_run(clock.run) and (self._clock is None or self._is_newer(clock, self._clock)):
            self._clock, self._stamp = clock, clock.stamp

    def on_state(self, state: WorldState) -> None:
        """Take a part of the state. The state changes once all parts of its tick have arrived."""
        if not self._is_current_run(state.run) or state.part >= state.parts:
            return
        newest = max((part.tick for part in self._parts.values()), default=-1)
        if self._is_seek_back(state.tick, newest):
            newest = -1
        if state.tick < newest:
            return
        if state.tick > newest or any(part.parts != state.parts for part in self._parts.values()):
            self._parts = {}
        self._parts[state.part] = state
        if len(self._parts) < state.parts:
            return
        back = state.tick < self._state_at[0]
        self._state_at = (state.tick, state.time)
        self._version += 1
        if back:
            self._speeds.clear()
        self._entities = tuple(
            self._with_steady_speed(entity, state.time)
            for part in sorted(self._parts)
            for entity in self._parts[part].entity
        )
        self._record_history(state.time, back=back)

    def on_event(self, event: Event) -> None:
        """Take an event. A gap in the numbers means that events were lost."""
        if not self._is_current_run(event.run):
            return
        if event.number > self._next_event and self.wants_events_since is None:
            self.wants_events_since = self._next_event
        self._store_event(event)

    def on_events(self, events: Events) -> None:
        """Take the answer to a query for events."""
        if not self._is_current_run(events.run):
            return
        for event in events.event:
            self._store_event(event)
        self._next_event = max(self._next_event, events.next)
        self.wants_events_since = None

    def on_map_info(self, info: MapInfo) -> None:
        """Take the name and hash of the current map."""
        if self._is_current_run(info.run):
            self._info = info

    def on_floor(self, floor: Map, asked: tuple[str, str] = ("", "")) -> None:
        """Take a map.

        Args:
            floor: The map. It does not name its run.
            asked: `map_in_use` when the map was queried. If that has changed, the map is ignored: it may be an old one.
        """
        if any(then and then != now for then, now in zip(asked, self.map_in_use, strict=True)):
            return
        self._floor_of = self.map_in_use
        if floor != self._floor:
            self._floor = floor
            self._revision += 1

    def on_body(self, body: Body) -> None:
        """Take a body."""
        if self._is_current_run(body.run) and body.robot.name is not None:
            self._bodies[body.robot.name] = body
            self._version += 1

    def on_measures(self, agent: str, measures: Measures) -> None:
        """Take the measures of an agent."""
        if self._is_current_run(measures.run):
            known = self._measures.get(agent)
            if known is None or measures.tick >= known.tick or self._is_seek_back(measures.tick, known.tick):
                self._measures[agent] = measures

    def on_reported(self, agent: str, pose: Pose) -> None:
        """Take a pose that a bridge reported, in a playback."""
        if self.is_log and pose.run == self._run and pose.tick is not None:
            self._version += self._reported.get(agent) != pose
            self._reported[agent] = pose

    def on_user_speech(self, text: str, to: str | None) -> None:
        """Take a message that a user sent from a page of this viewer. The state does not contain it."""
        self._utterances.append(Utterance(USER, self._state_at[1], text, to))
        self._version += 1

    @property
    def is_log(self) -> bool:
        """Whether this world is a playback."""
        return self._last_tick() is not None

    def forget(self, agents: Iterable[str]) -> None:
        """Drop the measures of agents that are no longer watched."""
        for agent in agents:
            self._measures.pop(agent, None)

    # ------------------------------------------------------------ snapshot out

    def snapshot(self, phase: Phase, world: str, worlds: tuple[str, ...], endpoint: str) -> Snapshot:
        """Return the current snapshot."""
        here = {entity.name for entity in self._entities}
        return Snapshot(
            phase=phase,
            world=world,
            worlds=worlds,
            endpoint=endpoint,
            run=self._run,
            tick=max(self._state_at[0], 0),
            time=self._state_at[1],
            clock=self._clock,
            floor=self._floor,
            revision=self._revision,
            bodies={name: self._bodies[name] for name in sorted(self._bodies) if name in here},
            entities=tuple(entity for entity in self._entities if entity.name in self._bodies),
            events=tuple(self._events[number] for number in sorted(self._events)),
            measures={name: measures for name, measures in self._measures.items() if name in here},
            reported={name: pose for name, pose in self._reported.items() if name in here and self._is_near(pose)},
            utterances=tuple(self._utterances),
            history=self._histories(here),
            last_tick=self._last_tick(),
            version=self._version,
        )

    def _with_steady_speed(self, entity: Entity, time: float) -> Entity:
        body = self._bodies.get(entity.name)
        is_real = body is not None and body.robot.type == "real"
        return self._speeds.smoothed(entity, time) if is_real else entity

    def _is_near(self, pose: Pose) -> bool:
        return pose.tick is not None and abs(pose.tick - self._state_at[0]) <= NEAR

    def _last_tick(self) -> int | None:
        return None if self._clock is None else self._clock.last

    def _histories(self, here: set[str]) -> Mapping[str, tuple[Sample, ...]]:
        if self._history_cache is None:
            self._history_cache = {name: tuple(samples) for name, samples in self._history.items() if name in here}
        return self._history_cache

    def _is_current_run(self, run: str) -> bool:
        """Return whether a message belongs to the current run. The first message of a new run starts that run here."""
        if run == self._run:
            return True
        if run in self._past:
            return False
        if self._run:
            self._past.append(self._run)
        self._run = run
        self._clock = None
        self._parts, self._entities, self._state_at = {}, (), (-1, 0.0)
        self._bodies, self._measures, self._history, self._saying = {}, {}, {}, {}
        self._history_cache = None
        self._speeds.clear()
        self._events, self._next_event, self.wants_events_since = {}, 0, 0
        self._utterances.clear()
        self._reported = {}
        self._info = None
        return True

    def _is_newer(self, clock: Clock, known: Clock) -> bool:
        """Return whether a clock is newer than the known one of the same run.

        While a run stands still, its ticks are equal and the stamp tells. A stamp alone would not do: whoever writes it
        may set the wall clock back. In a playback the tick may go back too.
        """
        return clock.stamp >= known.stamp or (clock.tick > known.tick and not self.is_log)

    def _is_seek_back(self, tick: int, newest: int) -> bool:
        """Return whether an older tick is a seek in a playback rather than a late message."""
        return self._last_tick() is not None and tick < newest

    def _store_event(self, event: Event) -> None:
        self._version += event.number not in self._events
        self._events[event.number] = event
        self._next_event = max(self._next_event, event.number + 1)
        for number in sorted(self._events)[:-EVENTS_KEPT]:
            del self._events[number]

    def _record_history(self, time: float, *, back: bool) -> None:
        self._history_cache = None
        if back:
            self._history.clear()
            self._utterances.clear()
        for entity in self._entities:
            self._note_speech(entity, time)
            samples = self._history.setdefault(entity.name, deque())
            if not samples or time - samples[-1].time >= 1.0 / SAMPLES_A_SECOND - 1e-9:
                ranges = _ranges(self._measures.get(entity.name))
                samples.append(Sample(time, entity.x, entity.y, entity.heading, entity.speed, ranges))
            while samples[0].time < time - HISTORY:
                samples.popleft()
        if len(self._history) > 2 * len(self._entities) + 8:
            here = {entity.name for entity in self._entities}
            self._history = {name: samples for name, samples in self._history.items() if name in here}

    def _note_speech(self, entity: Entity, time: float) -> None:
        """Record an utterance once; the state repeats it for as long as it lasts."""
        text = entity.say or ""
        if text and self._saying.get(entity.name) != text:
            self._utterances.append(Utterance(entity.name, time, text))
        self._saying[entity.name] = text


def _ranges(measures: Measures | None) -> tuple[float | None, ...]:
    if measures is None or measures.sensors is None:
        return ()
    return tuple(reading.value for reading in measures.sensors.proximity)
