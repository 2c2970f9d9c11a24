"""An agent on the network.

Zenoh calls back on its own threads. A callback stores what arrived and returns. Only the main loop calls the
harness and its mind. No single wait is longer than `SLICE`, so that a signal is noticed.
"""

from __future__ import annotations

import contextlib
import functools
import queue
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
from intellwheels_agents.simulator_session import (
    CONFIRM_TIMEOUT,
    JOIN_TIMEOUT,
    SLICE,
    Arrivals,
    ask,
    fetch_map,
    leave,
    log,
    run_in_session,
)
from intellwheels_schemas import link, zenoh_inbox
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Robot
from intellwheels_schemas.own_rights import denied_join
from intellwheels_schemas.process import start_network_thread


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

    def run(session: zenoh.Session, remaining: float) -> int:
        return _AgentPeer(
            session, robot, make, options, where, encoding, remaining, tell or _print, on_presence or _ignore,
            on_instance or _ignore,
        ).run(stop)  # fmt: skip

    return run_in_session(where, retry_for, stop, run)


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
        self._body_key = keys.body(agent)
        self._join_key = keys.join(agent)
        self._leave_key = keys.leave(agent)
        self._measures_key = keys.measures(agent)
        self._error_key = keys.error(agent)
        self._power_key = keys.power(agent)
        self._exit: int | None = None
        self._arrivals = Arrivals[_Answered]()
        self._watch = DecisionWatch(log)
        self._harness = Harness(
            robot,
            make,
            options=options,
            encoding=encoding,
            fetch_map=functools.partial(fetch_map, session, keys),
            simulator=where.where(),
            retry_for=retry_for,
        )
        role, instance = robot.role, robot.instance or ""
        channel = "pose" if role == "body" else "actions"
        put_key = keys.pose(agent) if role == "body" else keys.actions(agent)
        # The order prevents a race at joining: subscribe first, then declare the token, then ask.
        self._subscriber = session.declare_subscriber(keys.outs(agent), self._arrivals.store)
        self._publisher = link.declare(session, put_key, CHANNELS[channel], encoding)
        self._token_key = functools.partial(keys.token, agent, role)
        self._token: Any = link.declare_token(session, self._token_key(instance))
        self._simulator_token = session.liveliness().declare_subscriber(keys.alive, self._arrivals.notice, history=True)

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
                self._arrivals.report_dropped()
        return self._exit or 0

    def _disappear(self) -> None:
        self._token.undeclare()  # has no types

    def _reappear(self, instance: str) -> None:
        self._disappear()
        self._token = link.declare_token(self._session, self._token_key(instance))
        self._on_instance(instance)

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
            log(f"dropped key={key} why={error.text!r}")
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
                leave(self._session, self._leave_key, output.payload, self._encoding)
            elif isinstance(output, Print):
                self._tell(output.line)
            elif isinstance(output, Log):
                log(output.line)
            elif isinstance(output, Exit):
                self._exit = output.code
                if output.text:
                    log(output.text)

    def _ask(self, request: Literal["join", "clock", "body"], key: str, payload: bytes, timeout: float) -> None:
        """Query in a thread of its own, as an agent must keep answering ticks meanwhile; the answers will arrive."""

        def query() -> None:
            answers = ask(self._session, self._keys, key, payload, self._encoding, timeout)
            denied = ""
            if request == "join" and not any(answer.ok for answer in answers):
                # A denial looks like silence, and a token that is not let through like one that is missing.
                with contextlib.suppress(zenoh.ZError):
                    denied = denied_join(self._session, *self._joins_as, sure=bool(answers))
            self._arrivals.put(_Answered(request, [] if denied else answers, denied))

        start_network_thread(request, query)

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
            log(f"dropped reply=join why={error.text!r}")
            return self._harness.unanswered(now)
        return self._harness.accepted(payload) if answer.ok else self._harness.refused(payload, now)


def _ignore(_what: object) -> None:
    """Do nothing: nobody asked."""


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - scripts wait for these lines
