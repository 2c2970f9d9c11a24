"""An agent on the network. The only file of the agents that knows zenoh.

Zenoh calls back on its own threads. A callback stores what arrived and returns. Only the main loop calls the
harness and its mind. No single wait is longer than `SLICE`, so that a signal is noticed.

Arrivals wait in a `SimpleQueue`. It saves 25 µs a tick against a condition and a deque (measured round trip 128 µs
instead of 152 µs, echo of measures on loopback), and in lockstep every tick waits for every agent.
"""

from __future__ import annotations

import contextlib
import functools
import queue
import sys
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple

import zenoh

from intellwheels_agents.decision_watch import DecisionWatch
from intellwheels_agents.harness import Harness
from intellwheels_agents.harness_outputs import (
    AskBody,
    AskClock,
    Exit,
    Log,
    Output,
    Payload,
    Print,
    Publish,
    Reappear,
    RequestJoin,
    RequestLeave,
)
from intellwheels_agents.mind import Make
from intellwheels_schemas import link, zenoh_inbox
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import MAX_BYTES, Encoding, decode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Map, Robot
from intellwheels_schemas.own_rights import denied_join
from intellwheels_schemas.process import start_network_thread
from intellwheels_schemas.repliers import by_simulator
from intellwheels_schemas.session_closing import closing
from intellwheels_schemas.simulator_query import ask_simulator

SLICE = 0.2
"""Longest single wait, s: a wait without a timeout can miss a signal."""
JOIN_TIMEOUT = 12.0
"""Seconds to wait for the reply to a join: a strict lockstep may first wait ten seconds for another agent."""
CONFIRM_TIMEOUT = 2.0
"""Seconds to wait for the simulator to confirm what a message says."""
LEAVE_TIMEOUT = 2.0
"""Seconds to wait for the reply to a leave. Without a reply, the simulator still sees the liveliness token go."""
QUEUE_LIMIT = 1024
"""Arrivals that may wait while the mind computes: a minute at 20 Hz."""
ARRIVAL_LIMIT = MAX_BYTES
"""Largest arrival that is accepted, in bytes: the contract's limit for one message."""


class _Answered(NamedTuple):
    """What the simulator answered to a query; nothing if nobody answered, and why in words if that is known."""

    request: Literal["join", "clock", "body"]
    answers: list[link.Answer]
    denied: str = ""


def run_agent(
    robot: Robot,
    make: Make,
    options: Mapping[str, str],
    *,
    where: link.Link,
    encoding: Encoding,
    retry_for: float,
    stop: threading.Event,
    tell: Callable[[str], None] | None = None,
    on_presence: Callable[[bool], None] | None = None,
    on_instance: Callable[[str], None] | None = None,
) -> int:
    """Join, run the mind until `stop` is set, leave, and return the exit code.

    Args:
        robot: A document made by `robot_document.joining`.
        make: Makes a mind for each run.
        options: The mind's options.
        where: Which simulator to connect to, and how.
        encoding: The encoding of messages to the simulator, which answers in the same one.
        retry_for: Seconds to look for a simulator before giving up; may be infinite.
        stop: Set when the process must end.
        tell: Prints the lines that scripts wait for; default: to standard output.
        on_presence: Called in the calling thread when the simulator appears (True) or disappears (False).
        on_instance: Called in the calling thread with the instance of a new token, before the join with it.

    Raises:
        OptionError: The mind does not accept an option.
        ConnectionError: The options of `where` contradict each other.
    """
    started = time.monotonic()
    try:
        session = link.open_session(
            where,
            stop,
            timeout=retry_for if retry_for < 1e9 else None,
            waiting=lambda why: _log(f"waiting why={why!r}"),
        )
    except ConnectionError as error:
        _log(str(error))
        return 1
    if session is None:
        return 0
    with closing(session):
        remaining = max(0.0, retry_for - (time.monotonic() - started))
        return _AgentPeer(
            session, robot, make, options, where, encoding, remaining, tell or _print, on_presence or _ignore,
            on_instance or _ignore,
        ).run(stop)  # fmt: skip


class _AgentPeer:
    """One agent's subscriptions, liveliness token and publisher, and its loop."""

    def __init__(
        self,
        session: zenoh.Session,
        robot: Robot,
        make: Make,
        options: Mapping[str, str],
        where: link.Link,
        encoding: Encoding,
        retry_for: float,
        tell: Callable[[str], None],
        on_presence: Callable[[bool], None],
        on_instance: Callable[[str], None],
    ) -> None:
        agent = robot.name or ""
        keys = Keys(where.world)
        self._session = session
        self._tell = tell
        self._on_presence = on_presence
        self._on_instance = on_instance
        self._encoding = encoding
        self._keys = keys
        self._joins_as = where.world, robot.role, agent
        self._map_key = keys.map
        self._body_key = keys.body(agent)
        self._join_key = keys.join(agent)
        self._leave_key = keys.leave(agent)
        self._measures_key = keys.measures(agent)
        self._error_key = keys.error(agent)
        self._power_key = keys.power(agent)
        self._exit: int | None = None
        self._arrivals: queue.SimpleQueue[zenoh.Sample | zenoh_inbox.Presence | _Answered] = queue.SimpleQueue()
        self._dropped = 0
        self._watch = DecisionWatch(_log)
        self._harness = Harness(
            robot,
            make,
            options=options,
            encoding=encoding,
            fetch_map=self._fetch_map,
            simulator=where.where(),
            retry_for=retry_for,
        )
        role, instance = robot.role, robot.instance or ""
        channel = "pose" if role == "body" else "actions"
        put_key = keys.pose(agent) if role == "body" else keys.actions(agent)
        # The order prevents a race at joining: subscribe first, then declare the token, then ask.
        self._subscriber = session.declare_subscriber(keys.outs(agent), self._store)
        self._publisher = link.declare(session, put_key, CHANNELS[channel], encoding)
        self._token_key = functools.partial(keys.token, agent, role)
        self._token: Any = link.declare_token(session, self._token_key(instance))
        self._simulator_token = session.liveliness().declare_subscriber(keys.alive, self._notice, history=True)

    def run(self, stop: threading.Event) -> int:
        """Run until `stop` is set or the harness ends, and return the exit code."""
        harness = self._harness
        failed = True
        # Closed here and in order: a subscriber that is still open when Python exits makes it hang.
        with self._watch, self._publisher, contextlib.ExitStack() as presence, self._subscriber, self._simulator_token:
            presence.callback(self._disappear)
            try:
                self._do(harness.start(time.monotonic()))
                while self._exit is None and not stop.is_set():
                    self._turn()
                failed = False
            finally:
                outputs = harness.stop()
                if failed:
                    # Remove the body at once instead of after the timeout, but print no "left" line: this is a crash.
                    outputs = [output for output in outputs if isinstance(output, RequestLeave)]
                self._do(outputs)
                if self._dropped:
                    _log(f"overflowed arrivals={self._dropped}")
        return self._exit or 0

    def _disappear(self) -> None:
        self._token.undeclare()  # has no types

    def _reappear(self, instance: str) -> None:
        self._disappear()
        self._token = link.declare_token(self._session, self._token_key(instance))
        self._on_instance(instance)

    def _store(self, sample: zenoh.Sample) -> None:
        if self._arrivals.qsize() < QUEUE_LIMIT and len(sample.payload) <= ARRIVAL_LIMIT:
            self._arrivals.put(sample)
            return
        if self._dropped == 0:
            why = f"{len(sample.payload)} bytes, {self._arrivals.qsize()} waiting"
            _log(f"dropped key={sample.key_expr} why='{why}; expected at most {ARRIVAL_LIMIT} and {QUEUE_LIMIT}'")
        self._dropped += 1

    def _notice(self, token: zenoh.Sample) -> None:
        self._arrivals.put(zenoh_inbox.Presence(str(token.key_expr), token.kind == zenoh.SampleKind.PUT))

    def _turn(self) -> None:
        """Wait for arrivals or the harness's deadline, and handle what came."""
        harness = self._harness
        pause = SLICE
        if harness.deadline is not None:
            now = time.monotonic()
            if now >= harness.deadline:
                self._do(harness.wake(now))
                return
            pause = min(SLICE, harness.deadline - now)
        batch: list[Payload] = []
        replied = False
        try:
            arrival = self._arrivals.get(timeout=pause)
            self._watch.begin()
            while True:
                if isinstance(arrival, zenoh.Sample):
                    self._take(arrival, batch)
                elif isinstance(arrival, zenoh_inbox.Presence):
                    now = time.monotonic()
                    self._on_presence(arrival.alive)
                    self._do(harness.present(now) if arrival.alive else harness.absent(now))
                else:
                    self._do(self._replied(arrival, time.monotonic()))
                    replied = True
                arrival = self._arrivals.get_nowait()
        except queue.Empty:
            pass
        if replied:
            self._do(harness.measured_early(batch))
        elif batch:
            self._do(harness.measured(batch))
        self._watch.end()

    def _take(self, sample: zenoh.Sample, batch: list[Payload]) -> None:
        """Handle a sample; append `Measures` to `batch`, since only the newest of those waiting is answered."""
        if sample.kind != zenoh.SampleKind.PUT:
            return
        key = str(sample.key_expr)
        data = sample.payload.to_bytes()
        try:
            payload = data, encoding_of(str(sample.encoding), data)
        except WireError as error:
            _log(f"dropped key={key} why={error.text!r}")
            return
        if key == self._measures_key:
            batch.append(payload)
        elif key == self._error_key:
            self._do(self._harness.erred(payload, time.monotonic()))
        elif key == self._power_key:
            self._do(self._harness.powered(payload))

    def _do(self, outputs: list[Output]) -> None:
        for output in outputs:
            if isinstance(output, Publish):
                self._publisher.put(output.payload)
            elif isinstance(output, RequestJoin):
                self._ask("join", self._join_key, output.payload, JOIN_TIMEOUT)
            elif isinstance(output, Reappear):
                self._reappear(output.instance)
            elif isinstance(output, AskClock):
                self._ask("clock", self._keys.clock, b"", CONFIRM_TIMEOUT)
            elif isinstance(output, AskBody):
                self._ask("body", self._body_key, b"", CONFIRM_TIMEOUT)
            elif isinstance(output, RequestLeave):
                self._leave(output.payload)
            elif isinstance(output, Print):
                self._tell(output.line)
            elif isinstance(output, Log):
                _log(output.line)
            elif isinstance(output, Exit):
                self._exit = output.code
                if output.text:
                    _log(output.text)

    def _ask(self, request: Literal["join", "clock", "body"], key: str, payload: bytes, timeout: float) -> None:
        """Query in a thread of its own, as an agent must keep answering ticks meanwhile; the answers will arrive."""

        def ask() -> None:
            try:
                answers = link.query(self._session, key, payload, self._encoding, timeout=timeout)
                answers = by_simulator(answers, self._keys, self._claims)
            except (ConnectionError, zenoh.ZError):
                answers = []
            denied = ""
            if request == "join" and not any(answer.ok for answer in answers):
                # A denial looks like silence, and a token that is not let through like one that is missing.
                with contextlib.suppress(zenoh.ZError):
                    denied = denied_join(self._session, *self._joins_as, sure=bool(answers))
            self._arrivals.put(_Answered(request, [] if denied else answers, denied))

        start_network_thread(request, ask)

    def _claims(self) -> list[str]:
        return link.tokens(self._session, self._keys.every_claim)

    def _replied(self, arrival: _Answered, now: float) -> list[Output]:
        request, answers, denied = arrival
        if request == "body":
            return self._harness.bodied(any(answer.ok for answer in answers))
        if request == "clock":
            clocks = [(answer.data, encoding_of(answer.encoding, answer.data)) for answer in answers if answer.ok]
            return self._harness.clocked(clocks)
        if not answers:
            return self._harness.unanswered(now, denied)
        answer = answers[0]
        try:
            payload = answer.data, encoding_of(answer.encoding, answer.data)
        except WireError as error:
            _log(f"dropped reply=join why={error.text!r}")
            return self._harness.unanswered(now)
        return self._harness.accepted(payload) if answer.ok else self._harness.refused(payload, now)

    def _leave(self, payload: bytes) -> None:
        try:
            link.query(self._session, self._leave_key, payload, self._encoding, timeout=LEAVE_TIMEOUT)
        except (ConnectionError, zenoh.ZError) as error:
            # At the end of a scene the simulator may be gone already, which is no fault.
            _log(f"unanswered request=leave why={f'the simulator may have ended first: {error}'!r}")

    def _fetch_map(self) -> Map:
        answer = ask_simulator(self._session, self._keys, self._map_key, timeout=JOIN_TIMEOUT)[0]
        if not answer.ok:
            raise ConnectionError(f"map: expected the simulator's map, got an error: {answer.data[:200]!r}")
        return decode(Map, answer.data, encoding_of(answer.encoding, answer.data), strict=False)


def _ignore(_what: object) -> None:
    """Do nothing: nobody asked."""


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - scripts wait for these lines


def _log(line: str) -> None:
    sys.stderr.write(line + "\n")
    sys.stderr.flush()
