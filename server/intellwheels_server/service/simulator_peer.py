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
from intellwheels_schemas.keys import Claim, Keys, OutKind
from intellwheels_schemas.messages import Body, Clock, Event, MapInfo, Pose, Record, WorldState
from intellwheels_schemas.own_rights import denied_service
from intellwheels_schemas.process import SLICE
from intellwheels_schemas.repliers import mark_of
from intellwheels_schemas.router_link import open_words
from intellwheels_server.log.input_log import Log
from intellwheels_server.log.reported_poses import ReportedPoses
from intellwheels_server.log.run_files import RunFiles
from intellwheels_server.log.run_recorder import RunRecorder
from intellwheels_server.log.seekable_log import SeekableLog
from intellwheels_server.service import console
from intellwheels_server.service.arrival_reader import ArrivalReader
from intellwheels_server.service.live_run import LiveRun
from intellwheels_server.service.load_floor import load_floor
from intellwheels_server.service.log_playback import Playback
from intellwheels_server.service.main_loop import Service, run_service
from intellwheels_server.service.roster import new_hex
from intellwheels_server.service.service_state import Options
from intellwheels_server.service.side_process import SideProcess
from intellwheels_server.service.world_claim import WorldClaim

SHUTDOWN_TIME: Final = 0.1
"""Seconds that the last messages get to leave before the session closes."""
PRESENCE_TIMEOUT: Final = 1.0
"""Seconds in which another simulator of this world would answer."""


class WorldTakenError(RuntimeError):
    """Another simulator runs this world; the text says where."""


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
        self._parts: dict[int, zenoh.Publisher] = {}
        self._bodies: dict[str, zenoh.Publisher] = {}
        self._poses: dict[str, zenoh.Publisher] = {}
        self._event = link.declare(session, keys.event, CHANNELS["event"])
        self._clock = link.declare(session, keys.clock, CHANNELS["clock"])
        self._map = link.declare(session, keys.map, CHANNELS["map"])

    def agent(self, agent: str, kind: OutKind, message: Record, encoding: Encoding) -> None:
        """Put `out/<agent>/<kind>`, also for an agent that has not joined."""
        publishers = self._agents.get(agent)
        if publishers is not None:
            publisher, declared = publishers[kind]
            if declared is encoding:
                publisher.put(encode(message, encoding))
                return
        once = link.declare(self._session, self._keys.out(agent, kind), CHANNELS[kind], encoding)
        once.put(encode(message, encoding))
        _undeclare(once)

    def declare_agent(self, agent: str, mind: Encoding, body: Encoding) -> None:
        """Declare the publishers of an agent, except those that are declared already."""
        wanted: dict[OutKind, Encoding] = {"measures": mind, "power": body, "error": mind}
        self.read_keys.update(self._keys.read_of(agent))
        publishers = self._agents.setdefault(agent, {})
        for kind, encoding in wanted.items():
            if kind not in publishers or publishers[kind][1] is not encoding:
                if kind in publishers:
                    _undeclare(publishers[kind][0])
                key = self._keys.out(agent, kind)
                publishers[kind] = (link.declare(self._session, key, CHANNELS[kind], encoding), encoding)

    def undeclare_agent(self, agent: str) -> None:
        """Undeclare the publishers of an agent."""
        self.read_keys.difference_update(self._keys.read_of(agent))
        for publisher, _ in self._agents.pop(agent, {}).values():
            _undeclare(publisher)
        if agent in self._bodies:
            _undeclare(self._bodies.pop(agent))

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
        unix_time = steady_unix_time(time.time, _boot_time)
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


class ClaimWatch:
    """Claims the world for this process, and watches the claims of others.

    Args:
        session: The Zenoh session.
        keys: The keys of this world.

    Raises:
        WorldTakenError: Another simulator claimed it earlier.
    """

    def __init__(self, session: zenoh.Session, keys: Keys) -> None:
        self._session, self._keys = session, keys
        self._inbox = zenoh_inbox.Inbox()
        own = Claim(time.time_ns(), mark_of(str(session.info.zid())))
        self._token: Any = link.declare_token(session, keys.claim(own))
        self._watch = link.watch_tokens(session, keys.every_claim, self._inbox)
        self._claim = WorldClaim(own, _boot_time())
        self._asked = 0.0
        for key in link.tokens(session, keys.every_claim, timeout=PRESENCE_TIMEOUT):
            self._take(key, alive=True)
        try:
            self.begin()
            self.check()
            while self._claim.is_contested:
                self._inbox.wait(SLICE)
                self.check()
        except WorldTakenError:
            self.close()
            raise

    def begin(self) -> None:
        """Note that `check` is called from now on, at least once a second."""
        self._claim.begin(_boot_time())

    def check(self) -> None:
        """Take what is known of other claims.

        Raises:
            WorldTakenError: This simulator must end.
        """
        now = _boot_time()
        for arrival in self._inbox.take():
            if isinstance(arrival, zenoh_inbox.Presence):
                self._take(arrival.key, alive=arrival.alive)
        why = self._claim.yields(now)
        if why is not None:
            raise WorldTakenError(f"world '{self._keys.world}': {why}, so this one ends")
        if self._claim.is_in_doubt(now) and now - self._asked >= SLICE:
            self._asked = now
            link.look_for_tokens(self._session, self._keys.every_claim, self._inbox)

    def close(self) -> None:
        """Give up the claim."""
        _undeclare(self._watch)
        _undeclare(self._token)

    def _take(self, key: str, *, alive: bool) -> None:
        claim = self._keys.parse_claim(key)
        if claim is None:
            return
        if alive:
            self._claim.add(claim, _boot_time())
        else:
            self._claim.remove(claim)


def steady_unix_time(wall: Callable[[], float], steady: Callable[[], float]) -> Callable[[], float]:
    """Return a clock of Unix time in seconds that never goes back, as stamps order messages.

    Args:
        wall: The wall clock, which may be set at any time. It is read once.
        steady: Seconds of a clock that cannot be set.
    """
    offset = wall() - steady()
    return lambda: offset + steady()


def _boot_time() -> float:
    """Return seconds of a clock that goes on while the machine sleeps."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


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
        stack.enter_context(link.watch_tokens(session, keys.every_token, inbox))
        for key in (keys.every_join, keys.every_leave, *keys.every_ctl, keys.every_body, keys.every_state, keys.map,
                    keys.event, keys.clock):  # fmt: skip
            stack.enter_context(session.declare_queryable(key, inbox.queries_of(key)))
        token: Any = link.declare_token(session, keys.alive)
        floor_name = service.state.setup.floor.name
        console.log_line(f"serving world={options.world} pace={options.pace} map={floor_name} at={route.where()}")
        if route.identity is None:
            console.log_line(f"world={options.world} is {open_words(route.listen)}")
        console.print_line(f"ready world={options.world} run={service.state.run} listen={route.where()}")
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
