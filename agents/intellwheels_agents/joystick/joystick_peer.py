"""A joystick on the network. The only file of the joystick that knows zenoh.

One loop reads the source, sends its input and keeps the lease. Lease requests wait on a thread of their own, because a
slow answer must not delay the input.
"""

from __future__ import annotations

import queue
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import ExitStack, suppress
from typing import Final

import msgspec
import zenoh

from intellwheels_agents.joystick.input_latency import InputLatency
from intellwheels_agents.joystick.input_state import Source
from intellwheels_agents.joystick.input_timing import REPEAT_PERIOD, InputTiming
from intellwheels_agents.joystick.lease_client import LeaseClient
from intellwheels_schemas import link, own_rights, zenoh_inbox
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import MAX_BYTES, Encoding, decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Body, Clock, Error, Result, Take, UserInput, WorldState
from intellwheels_schemas.process import start_network_thread
from intellwheels_schemas.session_closing import closing

ANSWER_TIMEOUT: Final = 1.5
"""Seconds to wait for an answer: less than a lease."""
SAME_EVERY: Final = 5.0
"""Seconds in which the same error about the input is shown once."""
FINAL_TIMEOUT: Final = ANSWER_TIMEOUT + 1.0
"""Seconds to wait at the end for an outstanding answer: its own time-out, and a second for a busy machine."""

STATES_KEPT: Final = 256
"""States that may wait to be read: two seconds of a world in four parts."""


def operate(
    where: link.Link,
    agent: str,
    source: Source,
    *,
    take: bool,
    stop: threading.Event,
    retry_for: float | None,
    latency: bool = False,
    before_line: Callable[[], None] | None = None,
) -> int:
    """Send the input of a source until it ends or `stop` is set; return the exit code: 0, or 1 when refused.

    Args:
        where: The link.
        agent: The agent that is driven.
        source: The input device.
        take: Whether to take the chair from its mind, by a lease.
        stop: Set when the process must end.
        retry_for: Seconds to look for a router or simulator; None for no limit.
        latency: Whether to measure the time from the device to the motors, and print it at the end.
        before_line: Called before a line is printed while the source is read.
    """
    try:
        session = link.open_session(where, stop, timeout=retry_for, waiting=lambda why: _log(f"waiting why={why!r}"))
    except ConnectionError as error:
        _log(str(error))
        return 1
    if session is None:
        return 0
    with closing(session):
        keys = Keys(where.world)
        inbox = zenoh_inbox.Inbox()
        clock = session.declare_subscriber(keys.clock, inbox.on_sample)
        errors = session.declare_subscriber(keys.error(agent), inbox.on_sample)
        publisher = link.declare(session, keys.user(agent), CHANNELS["user"], Encoding.JSON)
        with ExitStack() as stack:
            for declared in (publisher, clock, errors):
                stack.enter_context(declared)
            take_key = keys.ctl("take", agent)
            # A put that is not allowed is dropped in silence.
            denied = own_rights.denied(session, keys.user(agent), "put", sure=True)
            if not denied and take:
                denied = own_rights.denied(session, take_key, "query", sure=True)
            if denied:
                _log(f"not driven agent={agent} why={denied!r}")
                return 1
            watch = _MotorWatch(agent) if latency else None
            if watch is not None:
                stack.enter_context(session.declare_subscriber(keys.every_state, watch.on_sample))
            requests = _LeaseRequests(session, take_key)
            _check_agent(session, keys.body(agent), agent, take=take)
            loop = _Loop(agent, source, requests, inbox, publisher, take=take, watch=watch, before_line=before_line)
            return loop.run(stop)


class _MotorWatch:
    """Takes the motor outputs of the chair from the state of the world, with their times of arrival."""

    def __init__(self, agent: str) -> None:
        self.latency = InputLatency()
        self._agent = agent
        self._arrived: deque[tuple[float, bytes, str]] = deque(maxlen=STATES_KEPT)

    def on_sample(self, sample: zenoh.Sample) -> None:
        """Keep a state, on a thread of Zenoh."""
        if len(sample.payload) <= MAX_BYTES:
            self._arrived.append((time.monotonic(), sample.payload.to_bytes(), str(sample.encoding)))

    def work(self) -> None:
        """Read the states that have arrived."""
        while self._arrived:
            at, data, encoding = self._arrived.popleft()
            with suppress(WireError):  # any peer can publish
                state = decode(WorldState, data, encoding_of(encoding, data), strict=False)
                for entity in state.entity:
                    if entity.name == self._agent:
                        self.latency.saw(entity.left_output, entity.right_output, at)


class _LeaseRequests:
    """Sends lease requests on a thread of their own."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._session = session
        self._key = key
        self.answers: queue.SimpleQueue[Result | None] = queue.SimpleQueue()

    def start(self, take: Take) -> None:
        """Send a request; the answer goes to `answers`."""
        start_network_thread("take", lambda: self.answers.put(self.ask(take)))

    def ask(self, take: Take) -> Result | None:
        """Send a request and return its answer, or None without one."""
        try:
            answers = link.query(self._session, self._key, encode(take, Encoding.JSON), timeout=ANSWER_TIMEOUT)
            return decode(Result, answers[0].data, encoding_of(answers[0].encoding, answers[0].data), strict=False)
        except (ConnectionError, WireError) as error:
            _log(f"unanswered verb=take why={str(error)!r}")
            return None


class _Loop:
    """The main loop of a joystick."""

    def __init__(
        self,
        agent: str,
        source: Source,
        requests: _LeaseRequests,
        inbox: zenoh_inbox.Inbox,
        publisher: zenoh.Publisher,
        *,
        take: bool,
        watch: _MotorWatch | None = None,
        before_line: Callable[[], None] | None = None,
    ) -> None:
        self._watch = watch
        self._before_line = before_line
        self._agent = agent
        self._source = source
        self._requests = requests
        self._inbox = inbox
        self._publisher = publisher
        self._timing = InputTiming()
        self._lease = LeaseClient(agent) if take else None
        self._time: float | None = None
        self._ignored, self._ignored_at = "", 0.0

    def run(self, stop: threading.Event) -> int:
        lease = self._lease
        self._print(f"ready agent={self._agent}")
        try:
            while not stop.is_set():
                now = time.monotonic()
                self._read_inbox()
                state = self._source.state(now, self._time)
                if state is None:
                    break
                if lease is not None:
                    self._keep_lease(lease, now)
                    if lease.failure:
                        self._log(f"not taken agent={self._agent} why={lease.failure!r}")
                        return 1
                if self._watch is not None:
                    self._watch.work()
                if lease is None or lease.lease is not None:
                    message = self._timing.message(state, now)
                    self._send(message)
                    if self._watch is not None and message is not None:
                        self._watch.latency.sent(state, time.monotonic())
                self._source.wait(REPEAT_PERIOD)
        finally:
            self._end()
        return 0

    def _keep_lease(self, lease: LeaseClient, now: float) -> None:
        request = lease.request(now)
        if request is not None:
            self._requests.start(request)
        while True:
            try:
                result = self._requests.answers.get_nowait()
            except queue.Empty:
                return
            if lease.answered(result, now):
                self._print(f"taken agent={self._agent}")

    def _end(self) -> None:
        self._send(self._timing.final_message(time.monotonic()))
        if self._lease is not None and self._lease.is_asking:
            # A lease may just be granted: wait for it, so that it is given back too.
            with suppress(queue.Empty):
                self._lease.answered(self._requests.answers.get(timeout=FINAL_TIMEOUT), time.monotonic())
        release = None if self._lease is None else self._lease.release()
        if release is not None:
            result = self._requests.ask(release)
            if result is not None and result.code == "ok":
                self._print(f"released agent={self._agent}")
        if self._watch is not None:
            self._print(f"latency agent={self._agent} {self._watch.latency.summary()}")
        self._print(f"ended agent={self._agent}")

    def _print(self, line: str) -> None:
        if self._before_line is not None:
            self._before_line()
        _print(line)

    def _log(self, line: str) -> None:
        if self._before_line is not None:
            self._before_line()
        _log(line)

    def _send(self, user: UserInput | None) -> None:
        if user is None:
            return
        if self._lease is not None:
            user = msgspec.structs.replace(user, lease=self._lease.lease)
        self._publisher.put(encode(user, Encoding.JSON))

    def _read_inbox(self) -> None:
        for arrival in self._inbox.take():
            if isinstance(arrival, zenoh_inbox.Put):
                try:
                    self._read(arrival)
                except WireError as error:
                    self._log(f"dropped key={arrival.key} why={error.text!r}")

    def _read(self, put: zenoh_inbox.Put) -> None:
        encoding = encoding_of(put.encoding, put.data)
        if not put.key.endswith("/error"):
            self._time = decode(Clock, put.data, encoding, strict=False).time
            return
        error = decode(Error, put.data, encoding, strict=False)
        # The others are about what the agent itself sends.
        if not (error.where or "").startswith("UserInput"):
            return
        now = time.monotonic()
        if error.text != self._ignored or now >= self._ignored_at + SAME_EVERY:
            self._ignored, self._ignored_at = error.text, now
            self._log(f"ignored agent={self._agent} code={error.code} why={error.text!r}")


def _check_agent(session: zenoh.Session, key: str, agent: str, *, take: bool) -> None:
    """Log when no agent has that name, or when it ignores user input. A put gets no reply that would say so."""
    try:
        answers = link.query(session, key, timeout=ANSWER_TIMEOUT)
        body = decode(Body, answers[0].data, encoding_of(answers[0].encoding, answers[0].data), strict=False)
    except own_rights.NotAllowedError as error:
        _log(f"waiting why={str(error)!r}")
        return
    except (ConnectionError, WireError):
        _log(f"waiting why='no agent {agent} yet'")
        return
    if not take and not {"drive", "words"}.intersection(body.robot.user_input):
        _log(f"ignored agent={agent} why='its robot declares no user input; --take drives it anyway'")


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - what a script waits for


def _log(line: str) -> None:
    print(f"iw-joystick: {line}", file=sys.stderr, flush=True)  # noqa: T201 - the log
