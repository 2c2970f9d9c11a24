"""The viewer on the network. The only file of the viewer that uses Zenoh.

Zenoh's threads put messages into an inbox; the drawing thread calls `update`, which passes them to the state store.
Queries block, so they run on other threads: a page's requests on the worker of that page, queries for missing data on a
thread of this file.
"""

from __future__ import annotations

import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Collection
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Final, TypeVar, cast

import zenoh

from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import EVERY_ALIVE, Keys, Verb, parse_alive
from intellwheels_schemas.link import Answer, Link, declare, open_session, query, tokens, watch_tokens
from intellwheels_schemas.messages import (
    AgentMeasures,
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
from intellwheels_schemas.own_rights import NotAllowedError
from intellwheels_schemas.process import start_network_thread
from intellwheels_schemas.repliers import by_simulator
from intellwheels_schemas.session_closing import close_session
from intellwheels_schemas.zenoh_inbox import Inbox, Presence, Put
from intellwheels_viewer.crew_watch import measures_in, subscriptions
from intellwheels_viewer.router_rights import RouterRights
from intellwheels_viewer.run_guard import Dated, RunGuard
from intellwheels_viewer.snapshot import Phase, Snapshot
from intellwheels_viewer.state_store import StateStore
from intellwheels_viewer.steering import VIEW_ONLY, Refusal

SILENCE: Final = 3.0
"""Seconds without a clock after which a simulator counts as silent. It sends two a second."""
ANSWER_LIMIT: Final = 3.0
"""Seconds a simulator has to answer a request."""
OPEN_LIMIT: Final = 5.0
"""Seconds to wait for the thread that opens the session; one attempt takes up to three."""
SETTLED: Final = 0.5
"""Seconds after the first world was found until it counts as the only one, as worlds are discovered one by one."""
FETCH_EVERY: Final = 1.0
"""Seconds between two queries for missing data."""
WATCHED_MOST: Final = 32
"""Above this many agents one wildcard subscription is cheaper than a subscription for each agent's measures."""

_M = TypeVar("_M", bound=Record)


@dataclass
class _World:
    """The subscriptions and the state of one world."""

    name: str
    keys: Keys
    inbox: Inbox = field(default_factory=Inbox)
    answers: deque[tuple[type[Record], Answer, tuple[str, str]]] = field(default_factory=deque)
    speech: deque[tuple[str, str | None]] = field(default_factory=deque)
    store: StateStore = field(default_factory=StateStore)
    guard: RunGuard = field(default_factory=RunGuard)
    subscribers: list[zenoh.Subscriber[None]] = field(default_factory=list)
    reports: zenoh.Subscriber[None] | None = None
    watched: dict[str, zenoh.Subscriber[None]] = field(default_factory=dict)
    shown: frozenset[str] = frozenset()
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
    """The link to a simulator, for as long as the viewer runs.

    Args:
        link: The endpoints, and the world to show first.
        stop: Set when the viewer must end.
        chosen: Whether the user named `link.world`. If not, the only running world is shown.

    Attributes:
        failure: Why no link is possible, in words; `stop` is then set. Empty otherwise.
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
        self._rights = RouterRights()
        self.failure = ""
        self._opener: threading.Thread | None = None

    def start(self) -> None:
        """Start looking for a simulator."""
        self._opener = start_network_thread("link", self._open)

    def close(self) -> None:
        """Close the link."""
        self._stop.set()
        # The opener checks `stop` often.
        if self._opener is not None:
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
                close_session(session)

    def choose(self, world: str) -> None:
        """Show another world; anything but a valid world name is ignored."""
        if is_name(world):
            self._wanted = world

    # ------------------------------------------------------------ messages in, on the drawing thread

    def update(self) -> Snapshot:
        """Take in all new messages, query missing data, and return the current snapshot."""
        now = time.monotonic()
        for arrival in self._presence.take():
            if isinstance(arrival, Presence) and (name := parse_alive(arrival.key)) is not None:
                self._note(name, arrival.alive)
        worlds = tuple(sorted(self._alive))
        self._follow(worlds, now)
        world = self._world
        if world is None:
            return Snapshot(
                phase=self._phase(worlds, now), worlds=worlds, endpoint=self._link.where(), world=self._wanted,
                rights=self._rights.identity,
            )  # fmt: skip
        self._store(world, now)
        self._hear_reports(world)
        self._fetch(world, now)
        snapshot = world.store.snapshot(self._phase(worlds, now), world.name, worlds, self._link.where())
        rights = self._rights.identity
        return snapshot if rights is None else replace(snapshot, rights=rights)

    def _hear_reports(self, world: _World) -> None:
        """In a playback, subscribe to the poses that bridges reported. In a live run the state already has them."""
        session = self._session
        if world.reports is None and world.store.is_log and session is not None:
            world.reports = session.declare_subscriber(f"{world.keys.prefix}in/*/pose", world.inbox.on_sample)

    def _note(self, name: str, alive: bool) -> None:
        if alive:
            self._alive.add(name)
        else:
            self._alive.discard(name)

    def watch(self, agents: Collection[str]) -> None:
        """Subscribe to the measures of these agents and of no others."""
        world, session = self._world, self._session
        if world is None or session is None:
            return
        wanted = subscriptions(world.keys, world.store.bodies, agents, WATCHED_MOST)
        for name in world.watched.keys() - wanted.keys():
            world.watched.pop(name).undeclare()  # type: ignore[no-untyped-call]
        # A late message of an ended subscription would otherwise be kept forever.
        world.store.forget(world.shown.difference(agents))
        world.shown = frozenset(agents)
        for name in wanted.keys() - world.watched.keys():
            world.watched[name] = session.declare_subscriber(wanted[name], world.inbox.on_sample)

    @property
    def quiet(self) -> float:
        """Seconds since the last clock."""
        return 0.0 if self._world is None else time.monotonic() - self._world.heard

    def _phase(self, worlds: tuple[str, ...], now: float) -> Phase:
        session = self._session
        if session is None or not (session.info.routers_zid() or session.info.peers_zid()):
            self._rights.doubt()
            return "no-router"
        self._rights.refresh(session)
        world = self._world
        if world is None or not self._was_there:
            return "choose" if worlds and self._wanted not in worlds else "no-world"
        if world.name not in worlds:
            return "gone"
        return "silent" if now - world.heard > SILENCE else "live"

    def _follow(self, worlds: tuple[str, ...], now: float) -> None:
        """Subscribe to the wanted world, or to the only one if the user named none."""
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
        with self._lock:  # a page may be publishing to the old one
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
                _deliver(Clock, answer, world.guard.confirm)
            _deliver(kind, answer, takes.get(kind, partial(store.on_floor, asked=asked)))
        while world.speech:
            store.on_user_speech(*world.speech.popleft())
        arrivals = [arrival for arrival in world.inbox.take() if isinstance(arrival, Put)]
        # Only the newest message of each per-tick key is decoded, so a slow viewer does not fall behind.
        newest = {arrival.key: index for index, arrival in enumerate(arrivals)}
        for index, put in enumerate(arrivals):
            if put.key == keys.event:
                _deliver(Event, put, store.on_event, world.guard)
            elif put.key == keys.map:
                _deliver(MapInfo, put, store.on_map_info, world.guard)
            elif keys.parse_body(put.key) is not None:
                _deliver(Body, put, store.on_body, world.guard)
            elif keys.parse_crew_measures(put.key) is not None:
                for agent, data in measures_in(put.data, put.encoding, world.shown):
                    _deliver(AgentMeasures, put._replace(data=data), partial(store.on_measures, agent), world.guard)
            elif newest[put.key] != index:
                continue
            elif put.key == keys.clock:
                world.heard = now
                _deliver(Clock, put, store.on_clock, world.guard)
            elif keys.parse_state(put.key) is not None:
                _deliver(WorldState, put, store.on_state, world.guard)
            elif (out := keys.parse_out(put.key)) is not None and out.kind == "measures":
                if out.agent in world.shown or "*" in world.watched:
                    _deliver(Measures, put, partial(store.on_measures, out.agent), world.guard)
            elif (report := keys.parse_in(put.key)) is not None and report.kind == "pose":
                _deliver(Pose, put, partial(store.on_reported, report.agent))

    # ------------------------------------------------------------ missing data

    def _fetch(self, world: _World, now: float) -> None:
        store = world.store
        missing_bodies = (
            store.map_is_missing or store.missing_bodies or store.wants_events_since is not None
            or world.asked == 0.0 or world.guard.doubts
        )  # fmt: skip
        if world.asking or not missing_bodies or now - world.asked < FETCH_EVERY or world.name not in self._alive:
            return
        world.asking, world.asked = True, now
        start_network_thread("fetch", partial(self._ask_for, world))

    def _ask_for(self, world: _World) -> None:
        """Query everything that was published before we subscribed, and queue the answers for the drawing thread."""
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
                    answers = by_simulator(answers, keys, lambda: tokens(session, keys.every_claim))
                    world.answers.extend((kind, answer, asked) for answer in answers if answer.ok)
        except (ConnectionError, zenoh.ZError):
            pass  # No answer, or the session was closed meanwhile; it is tried again later.
        finally:
            world.asking = False

    # ------------------------------------------------------------ requests out, on any thread

    @property
    def world(self) -> str:
        """The world that is shown; empty while there is none."""
        return "" if self._world is None else self._world.name

    def ask(self, verb: Verb, request: Record) -> Result:
        """Send a request to the simulator and return its answer. Blocks, so not for the drawing thread.

        Raises:
            Refusal: It was refused, got no answer, or this viewer is not allowed to control the simulation.
        """
        session, world = self._session, self._world
        if session is None or world is None:
            raise Refusal(f"No simulator at {self._link.where()}")
        try:
            data = encode(request)
        except ValueError:
            raise Refusal(f"{verb}: expected finite numbers, got NaN or infinity") from None
        try:
            answer = query(session, world.keys.ctl_of(verb, request), data, timeout=ANSWER_LIMIT, stop=self._stop)[0]
        except NotAllowedError as error:
            self._rights.doubt()  # the page does not know it yet
            raise Refusal(f"{VIEW_ONLY}: {error}") from None
        except (ConnectionError, zenoh.ZError):
            there = world.name in self._alive
            words = f"{VIEW_ONLY}: the simulator did not get this request" if there else "The simulator is not running"
            raise Refusal(words) from None
        try:
            result = decode(Result, answer.data, encoding_of(answer.encoding, answer.data), strict=False)
        except WireError as error:
            raise Refusal(f"Cannot read the simulator's answer: {error.text}") from None
        if not answer.ok or result.code != "ok":
            raise Refusal(result.text or f"{verb}: {result.code}")
        return result

    def put_user(self, agent: str, request: UserInput) -> None:
        """Publish a user's input. Never blocks and never repeats."""
        with self._lock:
            session, world = self._session, self._world
            if session is None or world is None:
                return
            publisher = world.users.get(agent)
            if publisher is None and not is_name(agent):
                return  # a page can send any text as its selection
            if publisher is None:
                publisher = world.users[agent] = declare(session, world.keys.user(agent), CHANNELS["user"])
            publisher.put(encode(request))

    def note_speech(self, text: str, to: str | None) -> None:
        """Show a message of a user in all pages; its receiver is an agent, or everybody with None."""
        world = self._world
        if world is not None:
            world.speech.append((text, to))

    # ------------------------------------------------------------ the session

    def _open(self) -> None:
        try:
            session = open_session(self._link, self._stop, waiting=_announce)
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


def _deliver(kind: type[_M], put: Put | Answer, take: Callable[[_M], None], guard: RunGuard | None = None) -> None:
    try:
        message = decode(kind, put.data, encoding_of(put.encoding, put.data), strict=False)
    except WireError:
        # Any peer can publish in a world; what cannot be decoded is ignored.
        return
    if guard is None or guard.counts(cast("Dated", message)):
        take(message)


def _announce(why: str) -> None:
    """Say on standard error what the viewer waits for; the page says it too."""
    sys.stderr.write(f"waiting why={why!r}\n")
    sys.stderr.flush()
