"""Messages of a run that never was, short to write, and a simulator that is only what a test lets it say."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Final

import msgspec
import zenoh

from intellwheels_experiments.run.endpoints import free_port
from intellwheels_maps import library
from intellwheels_schemas import link
from intellwheels_schemas.codec import decode, encode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import (
    Body,
    Clock,
    Entity,
    Event,
    Events,
    Map,
    MapInfo,
    Measures,
    ProximityReading,
    Record,
    Result,
    Sensors,
    UserInput,
    WorldState,
)

DEADLINE: Final = 20.0
RUN: Final = "00000000000000aa"
OTHER: Final = "00000000000000bb"
HASH: Final = "00000000000000ff"


def clock(tick: int = 0, run: str = RUN, stamp: float = 100.0, **more: Any) -> Clock:
    fields = {"state": "running", "pace": "realtime", "hash": HASH, **more}
    return Clock(run=run, tick=tick, time=tick * 0.05, stamp=stamp, **fields)


def entity(name: str, x: float = 0.0, y: float = 0.0, **more: Any) -> Entity:
    return Entity(name=name, x=x, y=y, heading=more.pop("heading", 0.0), **more)


def state(tick: int, *entities: Entity, run: str = RUN, part: int = 0, parts: int = 1) -> WorldState:
    return WorldState(run=run, tick=tick, time=tick * 0.05, part=part, parts=parts, entity=entities)


def body(name: str, run: str = RUN, robot: str = "rear-wheel", **more: Any) -> Body:
    return Body(run=run, tick=0, robot=msgspec.structs.replace(library.robot(robot), name=name, format=None, **more))


def event(number: int, code: str = "joined", run: str = RUN, tick: int = 0, **more: Any) -> Event:
    return Event(run=run, tick=tick, number=number, code=code, **more)  # type: ignore[arg-type]


def measures(tick: int, *values: float, run: str = RUN) -> Measures:
    readings = tuple(ProximityReading(id=f"s{k}", value=value) for k, value in enumerate(values))
    return Measures(run=run, tick=tick, time=tick * 0.05, sensors=Sensors(proximity=readings))


def info(run: str = RUN, hash_: str = HASH) -> MapInfo:
    return MapInfo(run=run, tick=0, name="room", revision=0, hash=hash_)


def until(there: Callable[[], Any], seconds: float = DEADLINE, what: str = "it") -> Any:
    """Wait until something is so, looking thirty times a second, as the drawing thread does."""
    pause, deadline = threading.Event(), time.monotonic() + seconds
    while not (found := there()):
        assert time.monotonic() < deadline, f"{what} did not come"
        pause.wait(0.03)
    return found


class Simulator:
    """Holds a world's token and answers what it is asked with what it was given.

    Attributes:
        floor, bodies, states, events: What is asked for.
        verdict: Answers verbs; gets the verb and the message. `None`: no answer at all.
        asked: The verbs that were asked, with their bytes.
        users: What came at `user/*`, the newest last.
    """

    def __init__(self, session: zenoh.Session, world: str) -> None:
        self.session, self.keys = session, Keys(world)
        self.floor: Map | None = library.floor("room")
        self.bodies: list[Body] = []
        self.states: list[WorldState] = []
        self.events: list[Event] = []
        self.clock: Clock | None = clock()
        self.verdict: Callable[[str, bytes], Result | bytes | None] = lambda verb, data: Result(code="ok")
        self.asked: list[tuple[str, bytes]] = []
        self.users: list[UserInput] = []
        self.fetched: list[str] = []
        keys = self.keys
        self._held: list[Any] = [
            *(session.declare_queryable(key, self._control) for key in keys.every_ctl),
            session.declare_queryable(keys.clock, lambda query: self._reply(query, self.clock)),
            session.declare_queryable(keys.map, lambda query: self._reply(query, self.floor)),
            session.declare_queryable(keys.every_body, self._all_bodies),
            session.declare_queryable(keys.every_state, self._all_states),
            session.declare_queryable(keys.event, self._all_events),
            session.declare_subscriber(keys.every_user, self._user),
        ]
        self._token: Any = link.declare_token(session, keys.alive)

    def leave(self) -> None:
        """Drop the token."""
        self._token.undeclare()

    def come(self) -> None:
        self._token = link.declare_token(self.session, self.keys.alive)

    def put(self, key: str, message: Record | bytes, encoding: str = "application/json;iw.v1") -> None:
        data = message if isinstance(message, bytes) else encode(message)
        self.session.put(key, data, encoding=encoding)

    def run(self, tick: int, *entities: Entity, stamp: float | None = None, run: str = RUN) -> None:
        """Put a clock and a state, and answer with them from now on."""
        self.clock = clock(tick, run, stamp=time.time() if stamp is None else stamp)
        self.states = [state(tick, *entities, run=run)]
        self.put(self.keys.clock, self.clock)
        self.put(self.keys.state(0), self.states[0])

    def _reply(self, query: zenoh.Query, message: Record | None, key: str | None = None) -> None:
        with query:
            self.fetched.append(str(query.selector))
            if message is not None:
                query.reply(key or str(query.key_expr), encode(message), encoding="application/json;iw.v1")

    def _all_bodies(self, query: zenoh.Query) -> None:
        with query:
            for each in self.bodies:
                key = self.keys.body(each.robot.name or "")
                query.reply(key, encode(each), encoding="application/json;iw.v1")

    def _all_states(self, query: zenoh.Query) -> None:
        with query:
            for each in self.states:
                query.reply(self.keys.state(each.part), encode(each), encoding="application/json;iw.v1")

    def _all_events(self, query: zenoh.Query) -> None:
        since = int(str(query.parameters).partition("since=")[2] or 0)
        kept = tuple(each for each in self.events if each.number >= since)
        following = max((each.number + 1 for each in self.events), default=0)
        run = RUN if self.clock is None else self.clock.run
        self._reply(query, Events(run=run, oldest=0, next=following, event=kept))

    def _control(self, query: zenoh.Query) -> None:
        with query:
            control = self.keys.parse_ctl(str(query.key_expr))
            assert control is not None
            verb = control.verb
            data = query.payload.to_bytes() if query.payload is not None else b""
            self.asked.append((verb, data))
            answer = self.verdict(verb, data)
            if answer is not None:
                payload = answer if isinstance(answer, bytes) else encode(answer)
                query.reply(str(query.key_expr), payload, encoding="application/json;iw.v1")

    def _user(self, sample: zenoh.Sample) -> None:
        self.users.append(decode(UserInput, sample.payload.to_bytes()))

    def close(self) -> None:
        for each in self._held:
            each.undeclare()


@contextmanager
def listening() -> Iterator[tuple[zenoh.Session, str]]:
    """A peer at a free loopback port, where worlds can be, and its endpoint."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    session = link.open_session(link.Link(listen=(endpoint,)), threading.Event(), timeout=DEADLINE)
    assert session is not None
    try:
        yield session, endpoint
    finally:
        session.close()  # type: ignore[no-untyped-call]


@contextmanager
def simulator(world: str) -> Iterator[tuple[Simulator, str]]:
    """A simulator of a world, and where it listens."""
    with listening() as (session, endpoint):
        made = Simulator(session, world)
        try:
            yield made, endpoint
        finally:
            made.close()
