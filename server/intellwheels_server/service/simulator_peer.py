"""The simulator on the network. The only file of the server that knows Zenoh, mostly through `link`.

Zenoh calls back on its own threads. Each callback only puts what arrived into the inbox. Only the main loop changes the
world, and each of its waits has a deadline.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Collection
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import zenoh

from intellwheels_schemas import link, zenoh_inbox
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.keys import Keys, OutKind
from intellwheels_schemas.messages import Body, Clock, CrewError, Event, MapInfo, Pose, Record
from intellwheels_schemas.own_rights import denied_service
from intellwheels_schemas.router_link import open_words
from intellwheels_server.log.input_log import Log
from intellwheels_server.log.reported_poses import ReportedPoses
from intellwheels_server.log.run_files import RunFiles
from intellwheels_server.log.run_recorder import RunRecorder
from intellwheels_server.log.seekable_log import SeekableLog
from intellwheels_server.service import console
from intellwheels_server.service.arrival_reader import ArrivalReader
from intellwheels_server.service.claim_watch import PRESENCE_TIMEOUT, ClaimWatch, WorldTakenError, boot_time
from intellwheels_server.service.live_run import LiveRun
from intellwheels_server.service.load_floor import load_floor
from intellwheels_server.service.log_playback import Playback
from intellwheels_server.service.main_loop import Service, run_service
from intellwheels_server.service.roster import new_hex
from intellwheels_server.service.service_state import Options
from intellwheels_server.service.side_process import SideProcess

SHUTDOWN_TIME: Final = 0.1
"""Seconds that the last messages get to leave before the session closes."""


class ZenohOutlet:
    """Puts messages with publishers that are declared once; a put never waits.

    Attributes:
        read_keys: The keys on which agents that are here, and users of bodies, may write.

    Args:
        session: The Zenoh session.
        keys: The keys of this world.
    """

    def __init__(self, session: zenoh.Session, keys: Keys) -> None:
        self.read_keys: set[str] = set()
        self._session = session
        self._keys = keys
        self._agents: dict[str, dict[str, tuple[zenoh.Publisher, Encoding]]] = {}
        self._put_measures: dict[str, Callable[[bytes], None]] = {}
        self._parts: dict[int, zenoh.Publisher] = {}
        self._bodies: dict[str, zenoh.Publisher] = {}
        self._poses: dict[str, zenoh.Publisher] = {}
        self._crews: dict[str, tuple[zenoh.Publisher, Encoding]] = {}
        self._crew_errors: dict[str, tuple[zenoh.Publisher, Encoding]] = {}  # of crews that have joined
        self._state_readers = link.declare(session, keys.every_state, CHANNELS["state"])
        self._event = link.declare(session, keys.event, CHANNELS["event"])
        self._clock = link.declare(session, keys.clock, CHANNELS["clock"])
        self._map = link.declare(session, keys.map, CHANNELS["map"])

    def agent(self, agent: str, kind: OutKind, message: Record, encoding: Encoding) -> None:
        """Put `out/<agent>/<kind>`, also for an agent that has not joined."""
        publisher, declared = self._agents.get(agent, {}).get(kind, (None, None))
        if publisher is not None and declared is encoding:
            publisher.put(encode(message, encoding))
            return
        once = link.declare(self._session, self._keys.out(agent, kind), CHANNELS[kind], encoding)
        once.put(encode(message, encoding))
        _undeclare(once)

    def put_measures(self, agent: str, data: bytes, _encoding: Encoding, /) -> None:
        """Put the bytes of measures on `out/<agent>/measures`. The agent must be declared, with that encoding."""
        self._put_measures[agent](data)

    def declare_agent(self, agent: str, mind: Encoding, body: Encoding) -> None:
        """Declare the publishers of an agent, except those that are declared already."""
        wanted: dict[OutKind, Encoding] = {"measures": mind, "power": body, "error": mind}
        self.read_keys.update(self._keys.read_of(agent))
        publishers = self._agents.setdefault(agent, {})
        for kind, encoding in wanted.items():
            if kind not in publishers or publishers[kind][1] is not encoding:
                if kind in publishers:
                    _undeclare(publishers[kind][0])
                publisher = link.declare(self._session, self._keys.out(agent, kind), CHANNELS[kind], encoding)
                publishers[kind] = publisher, encoding
        self._put_measures[agent] = publishers["measures"][0].put

    def undeclare_agent(self, agent: str) -> None:
        """Undeclare the publishers of an agent."""
        self._put_measures.pop(agent, None)
        self.read_keys.difference_update(self._keys.read_of(agent))
        for publisher, _ in self._agents.pop(agent, {}).values():
            _undeclare(publisher)
        if agent in self._bodies:
            _undeclare(self._bodies.pop(agent))

    def crew_measures(self, crew: str, data: bytes, encoding: Encoding) -> None:
        """Put encoded `CrewMeasures` on `crew/<crew>/measures`."""
        known = self._crews.get(crew)
        if known is None or known[1] is not encoding:
            self.undeclare_crew(crew)
            key = self._keys.crew_measures(crew)
            known = (link.declare(self._session, key, CHANNELS["crew_measures"], encoding), encoding)
            self._crews[crew] = known
            self.read_keys.add(self._keys.crew_actions(crew))
        known[0].put(data)

    def crew_error(self, crew: str, error: CrewError, encoding: Encoding) -> None:
        """Put `crew/<crew>/error`, also for a crew that has not joined."""
        publisher, declared = self._crew_errors.get(crew, (None, None))
        if publisher is not None and declared is encoding:
            publisher.put(encode(error, encoding))
            return
        new = link.declare(self._session, self._keys.crew_error(crew), CHANNELS["crew_error"], encoding)
        new.put(encode(error, encoding))
        if crew not in self._crews:
            _undeclare(new)
            return
        if publisher is not None:
            _undeclare(publisher)
        self._crew_errors[crew] = new, encoding

    def undeclare_crew(self, crew: str) -> None:
        """Undeclare the publishers of a crew, if there are any."""
        if crew in self._crews:
            self.read_keys.discard(self._keys.crew_actions(crew))
        for publishers in (self._crews, self._crew_errors):
            if crew in publishers:
                _undeclare(publishers.pop(crew)[0])

    def body(self, agent: str, body: Body) -> None:
        """Put `body/<agent>`."""
        if agent not in self._bodies:
            self.read_keys.update(self._keys.read_of(agent))
            self._bodies[agent] = link.declare(self._session, self._keys.body(agent), CHANNELS["body"])
        self._bodies[agent].put(encode(body))

    def pose(self, agent: str, pose: Pose) -> None:
        """Put `in/<agent>/pose`: in a playback, the pose that the bridge reported when the log was written."""
        if agent not in self._poses:
            self._poses[agent] = link.declare(self._session, self._keys.pose(agent), CHANNELS["pose"])
        self._poses[agent].put(encode(pose))

    def put_state(self, part: int, data: bytes) -> None:
        """Put the bytes of a part of the state on `state/<part>`."""
        if part not in self._parts:
            self._parts[part] = link.declare(self._session, self._keys.state(part), CHANNELS["state"])
        self._parts[part].put(data)

    def is_state_read(self) -> bool:
        """Return whether anybody subscribes to a part of the state. Nothing is put with this publisher."""
        return bool(self._state_readers.matching_status.matching)  # type: ignore[attr-defined]  # Zenoh says bool

    def event(self, event: Event) -> None:
        """Put `event`."""
        self._event.put(encode(event))

    def clock(self, clock: Clock) -> None:
        """Put `clock`."""
        self._clock.put(encode(clock))

    def map(self, info: MapInfo) -> None:
        """Put `map`."""
        self._map.put(encode(info))

    def print_line(self, line: str) -> None:
        """Print a line that scripts wait for."""
        console.print_line(line)

    def log_line(self, line: str) -> None:
        """Print a line for people."""
        console.log_line(line)


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
        options: How the service runs.
        route: The endpoints.
        stop: Set when the process must end.
        log_file: Where the input log goes, if anywhere.
        recording: The log to play; without one the run is live.
        reported: The log of the world in which the chairs of `recording` are real; their reported poses are shown.
        runs: A folder for the log and the trace of each run, if any.

    Raises:
        ConnectionError: The network cannot be reached; the text says why.
        WorldTakenError: Another simulator runs this world.
        OSError: The log cannot be written.
    """
    keys = Keys(options.world)
    with contextlib.ExitStack() as stack:
        # Before the session is opened: a process with a session must not fork.
        floors = stack.enter_context(closing(SideProcess(load_floor)))
        session = link.open_session(route, stop, waiting=lambda why: console.log_line(f"waiting why={why!r}"))
        if session is None:
            return 0
        stack.enter_context(session)
        if denied := denied_service(session, options.world):
            raise ConnectionError(denied)
        _check_free(session, keys, route)
        # Before a log is opened: a simulator that must end would replace the log of the one that goes on.
        claim = stack.enter_context(closing(ClaimWatch(session, keys)))
        outlet = ZenohOutlet(session, keys)
        unix_time = steady_unix_time(time.time, boot_time)
        if recording is not None:
            poses = None if reported is None else ReportedPoses(recording.runs, reported)
            playback = Playback(options, outlet, unix_time, recording, poses)
            return _serve(options, route, session, keys, stop, playback, claim, outlet.read_keys)
        run = new_hex()
        log = Log(log_file, options.setup, run, options.world) if log_file is not None else None
        files = None if runs is None else RunFiles(runs, options.world, lambda: live_run.state)
        with RunRecorder(log, files) as recorder:
            write = recorder.write if recorder.is_wanted else None
            live_run = LiveRun(options, outlet, floors, unix_time, record=write, run=run)
            if files is not None:
                live_run.observe_events(files.add_event)
            return _serve(options, route, session, keys, stop, live_run, claim, outlet.read_keys, recorder.flush_if_due)


def _check_free(session: zenoh.Session, keys: Keys, route: link.Link) -> None:
    if keys.alive in link.tokens(session, keys.alive, timeout=PRESENCE_TIMEOUT):
        raise WorldTakenError(
            f"world '{keys.world}' has a simulator already, at {route.where()}; "
            "give this one another name with --world, or stop the other one"
        )


def endpoint_words(route: link.Link) -> str:
    """Return the endpoints of a link, for programs: `listen=...`, `connect=...` or both; else `config=...`."""
    ends = ("listen", route.listen), ("connect", route.connect)
    return " ".join(f"{name}={','.join(found)}" for name, found in ends if found) or f"config={route.where()}"


def steady_unix_time(wall: Callable[[], float], steady: Callable[[], float]) -> Callable[[], float]:
    """Return a clock of Unix time in seconds that never goes back, as stamps order messages.

    Args:
        wall: The wall clock, which may be set at any time. It is read once.
        steady: Seconds of a clock that cannot be set.
    """
    offset = wall() - steady()
    return lambda: offset + steady()


def _serve(
    options: Options,
    route: link.Link,
    session: zenoh.Session,
    keys: Keys,
    stop: threading.Event,
    service: Service,
    claim: ClaimWatch,
    known: Collection[str],
    flush_if_due: Callable[[float], None] = lambda _now: None,
) -> int:
    inbox = zenoh_inbox.Inbox(known=known)
    with contextlib.ExitStack() as stack:
        service.begin()
        for key in keys.every_put:
            stack.enter_context(session.declare_subscriber(key, inbox.on_sample))
        for key in (keys.every_token, keys.every_crew_token):
            stack.enter_context(link.watch_tokens(session, key, inbox))
        for key in (keys.every_join, keys.every_leave, keys.every_crew_join, keys.every_crew_leave, *keys.every_ctl,
                    keys.every_body, keys.every_state, keys.map, keys.event, keys.clock):  # fmt: skip
            stack.enter_context(session.declare_queryable(key, inbox.queries_of(key)))
        token: Any = link.declare_token(session, keys.alive)
        floor_name = service.state.setup.floor.name
        console.log_line(f"serving world={options.world} pace={options.pace} map={floor_name} at={route.where()}")
        if route.identity is None:
            console.log_line(f"world={options.world} is {open_words(route.listen)}")
        console.print_line(f"ready world={options.world} run={service.state.run} {endpoint_words(route)}")
        try:
            claim.begin()
            run_service(service, ArrivalReader(keys), inbox, stop, claim.check, flush_if_due)
            service.finish(time.monotonic())
            console.log_line(f"ended run={service.state.run} tick={service.state.tick} hash={service.digest()}")
        finally:
            token.undeclare()
        time.sleep(SHUTDOWN_TIME)
    return service.exit or 0


def _undeclare(publisher: Any) -> None:
    publisher.undeclare()  # has no types
