"""The simulator on the network. The only file of the server that knows zenoh, and that through `link`.

Zenoh calls back on its own threads; every callback does one thing, put what arrived into the inbox. The loop alone
touches the world, and every wait of it ends.
"""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from functools import partial
from pathlib import Path
from typing import Any, Final, Protocol, TextIO, get_args

import zenoh

from intellwheels_maps import floor, names
from intellwheels_maps.check import check_map
from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys, OutKind
from intellwheels_schemas.messages import Body, Clock, Event, Load, Map, MapInfo, Pose, Record, WorldState
from intellwheels_schemas.process import SLICE
from intellwheels_server.log.input_log import Line, Log
from intellwheels_server.log.reported_poses import Reported
from intellwheels_server.log.run_files import RunFiles
from intellwheels_server.log.seekable_log import SeekableLog
from intellwheels_server.service.arrival import Arrival, Ask, Put, PutKind, Token, Topic
from intellwheels_server.service.live_run import LiveRun
from intellwheels_server.service.playback import Playback
from intellwheels_server.service.roster import new_hex
from intellwheels_server.service.service_state import Options, Recorder
from intellwheels_server.world import State
from intellwheels_server.world.inputs import Inputs

KEYS_KNOWN: Final = 4_096
"""Keys whose parts are remembered."""
TOPICS: Final[dict[str, Topic]] = {topic: topic for topic in get_args(Topic)}
SHUTDOWN: Final = 0.1
"""Seconds for what was put last to leave before the session closes."""
PRESENCE_TIMEOUT: Final = 1.0
"""Seconds in which another simulator of this world would say so."""


class WorldTakenError(RuntimeError):
    """There is a simulator in this world; the text says so."""


class Network:
    """The outlet: publishers declared once, a put never waits.

    Args:
        session: Where.
        keys: Of this world.
    """

    def __init__(self, session: zenoh.Session, keys: Keys) -> None:
        self._session = session
        self._keys = keys
        self._agents: dict[str, dict[str, tuple[zenoh.Publisher, Encoding]]] = {}
        self._parts: dict[int, zenoh.Publisher] = {}
        self._bodies: dict[str, zenoh.Publisher] = {}
        self._poses: dict[str, zenoh.Publisher] = {}
        self._event = link.declare(session, keys.event, CHANNELS["event"])
        self._clock = link.declare(session, keys.clock, CHANNELS["clock"])
        self._map = link.declare(session, keys.map, CHANNELS["map"])

    def agent(self, agent: str, kind: OutKind, message: Record, encoding: Encoding) -> None:
        """Put `out/<agent>/<kind>`, for who has not joined too."""
        publishers = self._agents.get(agent)
        if publishers is not None:
            publisher, declared = publishers[kind]
            if declared is encoding:
                publisher.put(encode(message, encoding))
                return
        once = link.declare(self._session, self._keys.out(agent, kind), CHANNELS[kind], encoding)
        once.put(encode(message, encoding))
        _undeclare(once)

    def welcome(self, agent: str, mind: Encoding, body: Encoding) -> None:
        """Declare what is put to this agent, unless it is declared so already."""
        wanted: dict[OutKind, Encoding] = {"measures": mind, "power": body, "error": mind}
        publishers = self._agents.setdefault(agent, {})
        for kind, encoding in wanted.items():
            if kind not in publishers or publishers[kind][1] is not encoding:
                if kind in publishers:
                    _undeclare(publishers[kind][0])
                key = self._keys.out(agent, kind)
                publishers[kind] = (link.declare(self._session, key, CHANNELS[kind], encoding), encoding)

    def farewell(self, agent: str) -> None:
        """Undeclare what was put to this agent."""
        for publisher, _ in self._agents.pop(agent, {}).values():
            _undeclare(publisher)
        if agent in self._bodies:
            _undeclare(self._bodies.pop(agent))

    def body(self, agent: str, body: Body) -> None:
        """Put `body/<agent>`."""
        if agent not in self._bodies:
            self._bodies[agent] = link.declare(self._session, self._keys.body(agent), CHANNELS["body"])
        self._bodies[agent].put(encode(body))

    def pose(self, agent: str, pose: Pose) -> None:
        """Put `in/<agent>/pose`, as its bridge did when the log that is played was written."""
        if agent not in self._poses:
            self._poses[agent] = link.declare(self._session, self._keys.pose(agent), CHANNELS["pose"])
        self._poses[agent].put(encode(pose))

    def state(self, state: WorldState) -> None:
        """Put `state/<part>`."""
        publisher = self._parts.get(state.part)
        if publisher is None:
            publisher = link.declare(self._session, self._keys.state(state.part), CHANNELS["state"])
            self._parts[state.part] = publisher
        publisher.put(encode(state))

    def event(self, event: Event) -> None:
        """Put `event`."""
        self._event.put(encode(event))

    def clock(self, clock: Clock) -> None:
        """Put `clock`."""
        self._clock.put(encode(clock))

    def map(self, info: MapInfo) -> None:
        """Put `map`."""
        self._map.put(encode(info))

    def tell(self, line: str) -> None:
        """Write a line that scripts wait for."""
        tell(line)

    def note(self, line: str) -> None:
        """Write a line for people."""
        note(line)


class Post:
    """Turns what zenoh brought into arrivals. Unknown keys are nobody's and become nothing.

    Args:
        keys: Of this world.
    """

    def __init__(self, keys: Keys) -> None:
        self._keys = keys
        # Whoever writes a key writes it again: its parts are looked up. Bounded, for keys are strangers' words.
        self._known: dict[str, tuple[str, PutKind]] = {}

    def open(self, arrival: link.Arrival) -> Arrival | None:
        """Return what an arrival is, or None when it is nothing to us."""
        if isinstance(arrival, link.Put):
            writer = self._writer(arrival.key)
            return Put(writer[0], writer[1], arrival.data, arrival.encoding) if writer else None
        if isinstance(arrival, link.Ask):
            return self._ask(arrival)
        if isinstance(arrival, link.Presence):
            token = self._keys.parse_token(arrival.key)
            return Token(token.agent, token.role, token.instance, arrival.alive) if token else None
        writer = self._writer(arrival.key)
        return Put(writer[0], writer[1], b"", "", arrival.length) if writer else None

    def _writer(self, key: str) -> tuple[str, PutKind] | None:
        try:
            return self._known[key]
        except KeyError:
            pass
        found: tuple[str, PutKind] | None = None
        if (put := self._keys.parse_in(key)) is not None:
            found = (put.agent, put.kind)
        elif (user := self._keys.parse_user(key)) is not None:
            found = (user, "user")
        if found is None:
            return None  # not remembered: keys of strangers may be 64 kB long
        if len(self._known) >= KEYS_KNOWN:
            self._known.clear()
        self._known[key] = found
        return found

    def _ask(self, arrival: link.Ask) -> Ask | None:
        keys = self._keys
        chunk = arrival.key.removeprefix(keys.prefix).partition("/")[0]
        topic = TOPICS.get(chunk) if arrival.key.startswith(keys.prefix) else None
        if topic is None:
            arrival.close()
            return None
        name = ""
        if topic == "join":
            name = keys.parse_join(arrival.key) or ""
        elif topic == "leave":
            name = keys.parse_leave(arrival.key) or ""
        elif topic == "ctl":
            name = keys.parse_ctl(arrival.key) or ""
        return Ask(
            topic=topic,
            name=name,
            data=arrival.data,
            encoding=arrival.encoding,
            send=partial(self._send, arrival, topic),
            close=arrival.close,
            parameters=_parameters(arrival.parameters),
            matches=partial(self._matches, zenoh.KeyExpr(arrival.key), topic),
            wild="*" in arrival.key,
        )

    def _matches(self, asked: zenoh.KeyExpr, topic: Topic, name: str) -> bool:
        return asked.intersects(zenoh.KeyExpr(f"{self._keys.prefix}{topic}/{name}"))

    def _send(
        self, arrival: link.Ask, topic: Topic, message: Record, encoding: Encoding, ok: bool, name: str | None
    ) -> None:
        data = encode(message, encoding)
        with contextlib.suppress(zenoh.ZError):  # who asked may be gone
            if ok:
                arrival.reply(data, encoding, None if name is None else f"{self._keys.prefix}{topic}/{name}")
            else:
                arrival.refuse(data, encoding)


def _parameters(text: str) -> dict[str, str]:
    pairs = (pair.partition("=") for pair in text.split(";") if pair)
    return {name: value for name, _, value in pairs}


def floor_of(load: Load) -> Map:
    """Return the floor that a `load` asks for.

    Raises:
        WireError: There is none of that name, or the map in it is wrong.
    """
    if load.map is None:
        known = names("floors")
        if load.name not in known:
            raise WireError("value", f"Load.Name: expected one of the floors ({', '.join(known)}), got '{load.name}'")
        return floor(str(load.name))
    findings = check_map(load.map)
    if findings:
        raise WireError("value", "; ".join(f"Load.{finding.element}: {finding.text}" for finding in findings[:3]))
    return load.map


class Director(Protocol):
    """What decides: a live run, or the playback of a log."""

    @property
    def exit(self) -> int | None:
        """The process's exit code once the service is over, else None."""

    @property
    def state(self) -> State:
        """The world."""

    def digest(self) -> str:
        """Return the hash of the state."""

    def begin(self) -> None:
        """Publish what there is to know before anything happens."""

    def take(self, arrival: Arrival, now: float) -> None:
        """Take in what arrived."""

    def work(self, now: float) -> None:
        """Do all that is due."""

    def due(self, now: float) -> float:
        """Return when `work` must be called next if nothing arrives."""

    def finish(self, now: float) -> None:
        """Publish what is left before the service ends."""


def serve(
    options: Options,
    route: link.Link,
    stop: threading.Event,
    log_file: Path | None = None,
    recording: SeekableLog | None = None,
    reported: SeekableLog | None = None,
    runs: Path | None = None,
) -> int:
    """Serve a world until it is over and return the exit code.

    Args:
        options: How.
        route: How to reach the others.
        stop: Set when the process must end.
        log_file: Where the input log goes, if anywhere.
        recording: The log to play; without one the run is live.
        reported: The log of the world in which its chairs are real, whose poses are told beside; see `Reported`.
        runs: A folder for the log and the trace of each run, if any.

    Raises:
        ConnectionError: The network cannot be reached, in words.
        WorldTakenError: There is a simulator in this world.
        OSError: The log cannot be written.
    """
    keys = Keys(options.world)
    session = link.open_session(route, stop, waiting=lambda why: note(f"waiting why={why!r}"))
    if session is None:
        return 0
    with session:
        if keys.alive in link.tokens(session, keys.alive, timeout=PRESENCE_TIMEOUT):
            raise WorldTakenError(
                f"world '{options.world}' has a simulator already, at {route.where()}; "
                "give this one another name with --world, or end that one"
            )
        network = Network(session, keys)
        if recording is not None:
            beside = None if reported is None else Reported(recording.runs, reported)
            player = Playback(options, network, time.time, recording, beside)
            return _serve(options, route, session, keys, stop, player)
        run = new_hex()
        log = Log(log_file, options.setup, run, options.world) if log_file is not None else None
        files = None if runs is None else RunFiles(runs, options.world, lambda: live_run.state)
        try:
            record = _recorder(log, files)
            live_run = LiveRun(options, network, floor_of, time.time, record=record, run=run)
            if files is not None:
                live_run.tell(files.happened)
            return _serve(options, route, session, keys, stop, live_run)
        finally:
            for each in (log, files):
                if each is not None:
                    each.close()


def _serve(
    options: Options,
    route: link.Link,
    session: zenoh.Session,
    keys: Keys,
    stop: threading.Event,
    live_run: Director,
) -> int:
    live_run.begin()
    inbox = link.Inbox()
    with contextlib.ExitStack() as stack:
        for key in (keys.every_in, keys.every_user):
            stack.enter_context(session.declare_subscriber(key, inbox.on_sample))
        stack.enter_context(link.watch_tokens(session, keys.every_token, inbox))
        for key in (keys.every_join, keys.every_leave, keys.every_ctl, keys.every_body, keys.every_state, keys.map,
                    keys.event, keys.clock):  # fmt: skip
            stack.enter_context(session.declare_queryable(key, inbox.on_query))
        token: Any = link.declare_token(session, keys.alive)
        floor_name = live_run.state.setup.floor.name
        note(f"serving world={options.world} pace={options.pace} map={floor_name} at={route.where()}")
        tell(f"ready world={options.world} run={live_run.state.run} listen={route.where()}")
        try:
            _loop(live_run, Post(keys), inbox, stop)
            live_run.finish(time.monotonic())
            note(f"ended run={live_run.state.run} tick={live_run.state.tick} hash={live_run.digest()}")
        finally:
            token.undeclare()
        time.sleep(SHUTDOWN)
    return live_run.exit or 0


def _recorder(log: Log | None, files: RunFiles | None) -> Recorder | None:
    if log is None and files is None:
        return None

    def record(tick: int, inputs: Inputs, digest: str, *, stepped: bool) -> None:
        if log is not None:
            log.write(Line(tick=tick, inputs=inputs, hash=digest, stepped=stepped), time.monotonic())
        if files is not None:
            files.record(tick, inputs, digest, stepped=stepped)

    return record


def _loop(live_run: Director, post: Post, inbox: link.Inbox, stop: threading.Event) -> None:
    """Take what arrives, move what is due, wait for the nearer of both: a life in a few lines."""
    dropped = 0
    while live_run.exit is None and not stop.is_set():
        now = time.monotonic()
        # An untimed wait in the main thread can miss a signal: never longer than a slice.
        left = min(live_run.due(now) - now, SLICE)
        if left > 0.0:
            inbox.wait(left)
            now = time.monotonic()
        for arrived in inbox.take():
            arrival = post.open(arrived)
            if arrival is not None:
                live_run.take(arrival, now)
        live_run.work(now)
        if inbox.dropped != dropped:
            note(f"dropped arrivals={inbox.dropped - dropped} why='more than can be read'")
            dropped = inbox.dropped


def _undeclare(publisher: Any) -> None:
    publisher.undeclare()  # has no types


def tell(line: str) -> None:
    """Write a line that scripts wait for to standard output; who does not read it does not stop the run."""
    _write(sys.stdout, line)


def note(line: str) -> None:
    """Write a line for people to standard error."""
    _write(sys.stderr, line)


def _write(stream: TextIO, line: str) -> None:
    with contextlib.suppress(OSError, ValueError):  # nobody reads any more
        print(line, file=stream, flush=True)
