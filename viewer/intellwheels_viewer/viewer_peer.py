"""The viewer on the network. The only file of the viewer that knows zenoh.

Zenoh's threads put what arrives into an inbox; `pour`, called by the drawing thread, folds it. Questions block, so
they are asked on threads of their own: a page's wish on the page's worker, what is missing on one of this file.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final, TypeVar

import zenoh

from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import EVERY_ALIVE, Keys, Verb, parse_alive
from intellwheels_schemas.link import (
    Answer,
    Inbox,
    Link,
    Presence,
    Put,
    declare,
    open_session,
    query,
    watch_tokens,
)
from intellwheels_schemas.messages import (
    Body,
    Clock,
    Event,
    Events,
    Map,
    MapInfo,
    Measures,
    Pose,
    Record,
    Result,
    UserInput,
    WorldState,
)
from intellwheels_schemas.names import is_name
from intellwheels_viewer.snapshot import Phase, Snapshot
from intellwheels_viewer.state_store import StateStore
from intellwheels_viewer.steering import Refusal

SILENCE: Final = 3.0
"""Seconds without a clock after which a simulator whose token is there is called silent: it sends two a second."""
ANSWER_LIMIT: Final = 3.0
"""Seconds a simulator has to answer a wish."""
OPEN_LIMIT: Final = 5.0
"""Seconds for who opens a session to see that it must end: one try may take three."""
SETTLED: Final = 0.5
"""Seconds after the first world was found until it counts as the only one: those that run are found one by one."""
FETCH_EVERY: Final = 1.0
"""Seconds between two askings for what is missing."""
WATCHED_MOST: Final = 32
"""Agents whose measures are subscribed one by one; beyond it a wildcard costs less than the declarations."""

_M = TypeVar("_M", bound=Record)


@dataclass
class _World:
    """One world's subscriptions, and what is known of it."""

    name: str
    keys: Keys
    inbox: Inbox = field(default_factory=Inbox)
    answers: deque[tuple[type[Record], Answer, tuple[str, str]]] = field(default_factory=deque)
    store: StateStore = field(default_factory=StateStore)
    subscribers: list[zenoh.Subscriber[None]] = field(default_factory=list)
    reports: zenoh.Subscriber[None] | None = None
    watched: dict[str, zenoh.Subscriber[None]] = field(default_factory=dict)
    users: dict[str, zenoh.Publisher] = field(default_factory=dict)
    heard: float = 0.0
    asked: float = 0.0
    asking: bool = False

    def close(self) -> None:
        for subscriber in (*self.subscribers, self.reports, *self.watched.values()):
            if subscriber is not None:
                subscriber.undeclare()  # type: ignore[no-untyped-call]
        for publisher in self.users.values():
            publisher.undeclare()  # type: ignore[no-untyped-call]


class Network:
    """The link to a simulator, kept up for as long as the viewer runs.

    Args:
        link: Where; `link.world` is watched first.
        stop: Set when the viewer must end.
        chosen: Whether `link.world` is the one that is wanted; else the only one there is is taken.

    Attributes:
        failure: Why the link cannot be, in words; `stop` is then set. Empty while it can.
    """

    def __init__(self, link: Link, stop: threading.Event, *, chosen: bool = True) -> None:
        self._link, self._stop = link, stop
        self._wanted = link.world if chosen else ""
        self._session: zenoh.Session | None = None
        self._alive: set[str] = set()
        self._presence = Inbox()
        self._tokens: zenoh.Subscriber[None] | None = None
        self._world: _World | None = None
        self._was_there = False
        self._found_at = 0.0
        self._closed = False
        self._lock = threading.Lock()
        self.failure = ""
        self._opener = threading.Thread(target=self._open, name="link", daemon=True)

    def start(self) -> None:
        """Begin to look for a simulator."""
        self._opener.start()

    def close(self) -> None:
        """Hear nothing further."""
        self._stop.set()
        # A process that ends while another thread is inside Zenoh is aborted: who opens sees the stop soon.
        if self._opener.is_alive():
            self._opener.join(OPEN_LIMIT)
        with self._lock:
            self._closed = True
            session, self._session = self._session, None
            if self._world is not None and session is not None:
                self._world.close()
            self._world = None
            if self._tokens is not None:
                self._tokens.undeclare()  # type: ignore[no-untyped-call]
            if session is not None:
                session.close()  # type: ignore[no-untyped-call]

    def choose(self, world: str) -> None:
        """Watch another world; a text that is no world's name changes nothing."""
        if is_name(world):
            self._wanted = world

    # ------------------------------------------------------------ in, on the drawing thread

    def pour(self) -> Snapshot:
        """Fold what arrived since the last time, ask for what is missing, and return what is known."""
        now = time.monotonic()
        for arrival in self._presence.take():
            if isinstance(arrival, Presence) and (name := parse_alive(arrival.key)) is not None:
                self._note(name, arrival.alive)
        worlds = tuple(sorted(self._alive))
        self._follow(worlds, now)
        world = self._world
        if world is None:
            return Snapshot(
                phase=self._phase(worlds, now), worlds=worlds, endpoint=self._link.where(), world=self._wanted
            )
        self._store(world, now)
        self._hear_reports(world)
        self._fetch(world, now)
        return world.store.seen(self._phase(worlds, now), world.name, worlds, self._link.where())

    def _hear_reports(self, world: _World) -> None:
        """In a log that is played hear what bridges had reported; in a live run it is what the state says."""
        session = self._session
        if world.reports is None and world.store.is_log and session is not None:
            world.reports = session.declare_subscriber(f"{world.keys.prefix}in/*/pose", world.inbox.on_sample)

    def _note(self, name: str, alive: bool) -> None:
        if alive:
            self._alive.add(name)
        else:
            self._alive.discard(name)

    def watch(self, agents: Collection[str]) -> None:
        """Hear the measures of these agents, and of no others."""
        world, session = self._world, self._session
        if world is None or session is None:
            return
        wanted = {"*"} if len(agents) > WATCHED_MOST else set(agents)
        for name in world.watched.keys() - wanted:
            world.watched.pop(name).undeclare()  # type: ignore[no-untyped-call]
            world.store.forget([name])
        for name in wanted - world.watched.keys():
            key = f"{world.keys.prefix}out/*/measures" if name == "*" else world.keys.measures(name)
            world.watched[name] = session.declare_subscriber(key, world.inbox.on_sample)

    @property
    def quiet(self) -> float:
        """Seconds since the last clock."""
        return 0.0 if self._world is None else time.monotonic() - self._world.heard

    def _phase(self, worlds: tuple[str, ...], now: float) -> Phase:
        session = self._session
        if session is None or not (session.info.routers_zid() or session.info.peers_zid()):
            return "no-router"
        world = self._world
        if world is None or not self._was_there:
            return "choose" if worlds and self._wanted not in worlds else "no-world"
        if world.name not in worlds:
            return "gone"
        return "silent" if now - world.heard > SILENCE else "live"

    def _follow(self, worlds: tuple[str, ...], now: float) -> None:
        """Watch the world that is wanted, once it is there; the only one when none is."""
        session = self._session
        wanted = self._wanted
        if not worlds:
            self._found_at = now
        if not wanted and len(worlds) == 1 and now - self._found_at >= SETTLED:
            wanted = self._wanted = worlds[0]
        if session is None or not wanted or (self._world is not None and self._world.name == wanted):
            self._was_there = self._was_there or wanted in worlds
            return
        world = _World(wanted, Keys(wanted))
        keys = world.keys
        for key in (keys.map, keys.event, keys.clock, keys.every_state, keys.every_body):
            world.subscribers.append(session.declare_subscriber(key, world.inbox.on_sample))
        self._was_there = wanted in worlds
        with self._lock:  # a page may be putting into the old one
            old, self._world = self._world, world
            if old is not None:
                old.close()

    def _store(self, world: _World, now: float) -> None:
        keys, store = world.keys, world.store
        takes: dict[type[Record], Callable[[Any], None]] = {
            Clock: store.on_clock, Body: store.on_body, WorldState: store.on_state, Events: store.on_events,
        }  # fmt: skip
        while world.answers:
            kind, answer, asked = world.answers.popleft()
            if kind is Clock:
                world.heard = now
            _give(kind, answer, takes.get(kind, partial(store.on_floor, asked=asked)))
        arrivals = [arrival for arrival in world.inbox.take() if isinstance(arrival, Put)]
        # Of what is put each tick only the newest is decoded; that keeps a slow viewer from falling behind.
        newest = {arrival.key: index for index, arrival in enumerate(arrivals)}
        for index, put in enumerate(arrivals):
            if put.key == keys.event:
                _give(Event, put, store.on_event)
            elif put.key == keys.map:
                _give(MapInfo, put, store.on_map_info)
            elif keys.parse_body(put.key) is not None:
                _give(Body, put, store.on_body)
            elif newest[put.key] != index:
                continue
            elif put.key == keys.clock:
                world.heard = now
                _give(Clock, put, store.on_clock)
            elif keys.parse_state(put.key) is not None:
                _give(WorldState, put, store.on_state)
            elif (
                (out := keys.parse_out(put.key)) is not None
                and out.kind == "measures"
                and _is_watched(world, out.agent)
            ):
                _give(Measures, put, partial(store.on_measures, out.agent))
            elif (report := keys.parse_in(put.key)) is not None and report.kind == "pose":
                _give(Pose, put, partial(store.on_reported, report.agent))

    # ------------------------------------------------------------ what is missing

    def _fetch(self, world: _World, now: float) -> None:
        store = world.store
        lacks = store.lacks_map or store.lacks or store.wants_events_since is not None or world.asked == 0.0
        if world.asking or not lacks or now - world.asked < FETCH_EVERY or world.name not in self._alive:
            return
        world.asking, world.asked = True, now
        threading.Thread(target=self._ask_for, args=(world,), name="fetch", daemon=True).start()

    def _ask_for(self, world: _World) -> None:
        """Ask for all that a late comer missed, and put the answers where the drawing thread finds them."""
        keys, session = world.keys, self._session
        since, asked = world.store.wants_events_since or 0, world.store.map_in_use
        wanted: tuple[tuple[str, type[Record]], ...] = (
            (keys.clock, Clock), (keys.map, Map), (keys.every_body, Body), (keys.every_state, WorldState),
            (f"{keys.event}?since={since}", Events),
        )  # fmt: skip
        try:
            for selector, kind in wanted:
                if session is not None:
                    answers = query(session, selector, timeout=ANSWER_LIMIT, stop=self._stop)
                    world.answers.extend((kind, answer, asked) for answer in answers if answer.ok)
        except (ConnectionError, zenoh.ZError):
            pass  # Nobody there, or the session was closed meanwhile: it is asked for again.
        finally:
            world.asking = False

    # ------------------------------------------------------------ out, on any thread

    def ask(self, verb: Verb, wish: Record) -> Result:
        """Ask the simulator for something and return what it answered. Waits; not for the drawing thread.

        Raises:
            Refusal: It was refused, nobody answers, or this viewer may not ask.
        """
        session, world = self._session, self._world
        if session is None or world is None:
            raise Refusal(f"No simulator at {self._link.where()}")
        try:
            data = encode(wish)
        except ValueError:
            raise Refusal(f"{verb}: expected finite numbers") from None
        try:
            answer = query(session, world.keys.ctl(verb), data, timeout=ANSWER_LIMIT, stop=self._stop)[0]
        except (ConnectionError, zenoh.ZError):
            there = world.name in self._alive
            words = "You may look, not steer: nobody answers this wish" if there else "The simulator is not there"
            raise Refusal(words) from None
        try:
            result = decode(Result, answer.data, encoding_of(answer.encoding, answer.data), strict=False)
        except WireError as error:
            raise Refusal(f"The simulator's answer cannot be read: {error.text}") from None
        if not answer.ok or result.code != "ok":
            raise Refusal(result.text or f"{verb}: {result.code}")
        return result

    def put_user(self, agent: str, wish: UserInput) -> None:
        """Put what a person wants; it never waits and is never repeated."""
        with self._lock:
            session, world = self._session, self._world
            if session is None or world is None:
                return
            publisher = world.users.get(agent)
            if publisher is None and not is_name(agent):
                return  # what a page selects may be any text
            if publisher is None:
                publisher = world.users[agent] = declare(session, world.keys.user(agent), CHANNELS["user"])
            publisher.put(encode(wish))

    # ------------------------------------------------------------ the session

    def _open(self) -> None:
        try:
            session = open_session(self._link, self._stop)
        except ConnectionError as error:
            self.failure = str(error)
            self._stop.set()
            return
        if session is None:
            return
        with self._lock:
            if self._closed:
                session.close()  # type: ignore[no-untyped-call]
                return
            self._tokens = watch_tokens(session, EVERY_ALIVE, self._presence)
            self._session = session


def _is_watched(world: _World, agent: str) -> bool:
    """Return whether measures are kept: what was under way when its subscription ended would stay for ever."""
    return agent in world.watched or "*" in world.watched


def _give(kind: type[_M], put: Put | Answer, take: Callable[[_M], None]) -> None:
    try:
        message = decode(kind, put.data, encoding_of(put.encoding, put.data), strict=False)
    except WireError:
        # In a world others may write too what cannot be read is nobody's.
        return
    take(message)
