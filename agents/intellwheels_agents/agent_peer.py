"""An agent on the network. The only file of the agents that knows zenoh.

Zenoh calls back on its own threads; a callback keeps what arrived and returns. The main loop alone
touches the harness and its mind. No wait is longer than a slice, so that a signal is seen.

What arrives is kept in a `SimpleQueue`: 25 µs a tick less than a condition and a deque (a round trip of 128 µs
instead of 152, an echo of measures on loopback), and a lockstep waits for every one of them.
"""

from __future__ import annotations

import queue
import sys
import threading
import time
from collections.abc import Callable, Mapping

import zenoh

from intellwheels_agents.harness import Ask, Depart, End, Harness, Note, Output, Payload, Put, Tell
from intellwheels_agents.mind import Make
from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, decode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Map, Robot

SLICE = 0.2
"""Seconds of one wait: an untimed one can miss a signal."""
JOIN_TIMEOUT = 12.0
"""Seconds to wait for the reply to a join: a strict lockstep may wait ten for somebody else first."""
LEAVE_TIMEOUT = 2.0
"""Seconds to wait for the reply to a leave; the token goes with the session in any case."""
ROOM = 1024
"""Arrivals kept while the mind thinks: a minute at 20 Hz."""
MOST_BYTES = 1 << 18
"""Bytes of an arrival that is kept: four times what one put of the contract may have."""


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
) -> int:
    """Join, decide until told to stop, leave, and return the exit code.

    Args:
        robot: As `equipment.joining` makes it.
        make: Makes a mind at each run.
        options: The mind's.
        where: The link.
        encoding: Of what is written, and so of what comes back.
        retry_for: Seconds to look for a simulator before giving up; may be infinite.
        stop: Set when the process must end.
        tell: Takes the lines that scripts wait for; default: standard output.

    Raises:
        OptionError: The mind takes other options.
        ConnectionError: The link's options make no sense.
    """
    began = time.monotonic()
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
    with session:
        left = max(0.0, retry_for - (time.monotonic() - began))
        return _Process(session, robot, make, options, where, encoding, left, tell or _print).run(stop)


class _Process:
    """One agent's session: subscriptions, token, publisher and the loop."""

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
    ) -> None:
        agent = robot.name or ""
        keys = Keys(where.world)
        self._session = session
        self._tell = tell
        self._encoding = encoding
        self._map_key = keys.map
        self._join_key = keys.join(agent)
        self._leave_key = keys.leave(agent)
        self._measures_key = keys.measures(agent)
        self._error_key = keys.error(agent)
        self._power_key = keys.power(agent)
        self._exit: int | None = None
        self._arrived: queue.SimpleQueue[zenoh.Sample | link.Presence | list[link.Answer]] = queue.SimpleQueue()
        self._overflown = 0
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
        # In this order a join has no race: hear, be seen, ask.
        self._subscriber = session.declare_subscriber(keys.outs(agent), self._keep)
        self._publisher = link.declare(session, put_key, CHANNELS[channel], encoding)
        self._token = link.declare_token(session, keys.token(agent, role, instance))
        self._watch = session.liveliness().declare_subscriber(keys.alive, self._notice, history=True)

    def run(self, stop: threading.Event) -> int:
        """Loop until it is over and return the exit code."""
        harness = self._harness
        broken = True
        # Closed in order, not at exit: a subscriber left to the end hangs Python.
        with self._publisher, self._token, self._subscriber, self._watch:
            try:
                self._do(harness.start(time.monotonic()))
                while self._exit is None and not stop.is_set():
                    self._turn()
                broken = False
            finally:
                outputs = harness.stop()
                if broken:
                    # The body must not wait for a time-out; but who died does not say that it left.
                    outputs = [output for output in outputs if isinstance(output, Depart)]
                self._do(outputs)
                if self._overflown:
                    _log(f"overflown arrivals={self._overflown}")
        return self._exit or 0

    def _keep(self, sample: zenoh.Sample) -> None:
        if self._arrived.qsize() < ROOM and len(sample.payload) <= MOST_BYTES:
            self._arrived.put(sample)
        else:
            self._overflown += 1

    def _notice(self, token: zenoh.Sample) -> None:
        self._arrived.put(link.Presence(str(token.key_expr), token.kind == zenoh.SampleKind.PUT))

    def _turn(self) -> None:
        harness = self._harness
        pause = SLICE
        if harness.deadline is not None:
            now = time.monotonic()
            if now >= harness.deadline:
                self._do(harness.wake(now))
                return
            pause = min(SLICE, harness.deadline - now)
        came: list[Payload] = []
        try:
            arrival = self._arrived.get(timeout=pause)
            while True:
                if isinstance(arrival, zenoh.Sample):
                    self._take(arrival, came)
                elif isinstance(arrival, link.Presence):
                    now = time.monotonic()
                    self._do(harness.present(now) if arrival.alive else harness.absent(now))
                else:
                    self._do(self._replied(arrival, time.monotonic()))
                arrival = self._arrived.get_nowait()
        except queue.Empty:
            pass
        if came:
            self._do(harness.measured(came))

    def _take(self, sample: zenoh.Sample, came: list[Payload]) -> None:
        """Hand a sample on, `Measures` to `came`: of those that wait only the newest is answered."""
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
            came.append(payload)
        elif key == self._error_key:
            self._do(self._harness.erred(payload, time.monotonic()))
        elif key == self._power_key:
            self._do(self._harness.powered(payload))

    def _do(self, outputs: list[Output]) -> None:
        for output in outputs:
            if isinstance(output, Put):
                self._publisher.put(output.payload)
            elif isinstance(output, Ask):
                # Beside the loop: who joins again is still awaited at the barrier meanwhile.
                threading.Thread(target=self._ask, args=(output.payload,), name="join", daemon=True).start()
            elif isinstance(output, Depart):
                self._depart(output.payload)
            elif isinstance(output, Tell):
                self._tell(output.line)
            elif isinstance(output, Note):
                _log(output.line)
            elif isinstance(output, End):
                self._exit = output.code
                if output.text:
                    _log(output.text)

    def _ask(self, payload: bytes) -> None:
        try:
            answers = link.query(self._session, self._join_key, payload, self._encoding, timeout=JOIN_TIMEOUT)
        except (ConnectionError, zenoh.ZError):
            answers = []
        self._arrived.put(answers)

    def _replied(self, answers: list[link.Answer], now: float) -> list[Output]:
        if not answers:
            return self._harness.unanswered(now)
        answer = answers[0]
        try:
            payload = answer.data, encoding_of(answer.encoding, answer.data)
        except WireError as error:
            _log(f"dropped reply=join why={error.text!r}")
            return self._harness.unanswered(now)
        return self._harness.accepted(payload) if answer.ok else self._harness.refused(payload, now)

    def _depart(self, payload: bytes) -> None:
        try:
            link.query(self._session, self._leave_key, payload, self._encoding, timeout=LEAVE_TIMEOUT)
        except (ConnectionError, zenoh.ZError) as error:
            _log(f"left without=reply why={str(error)!r}")

    def _fetch_map(self) -> Map:
        answer = link.query(self._session, self._map_key, encoding=Encoding.JSON, timeout=JOIN_TIMEOUT)[0]
        if not answer.ok:
            raise ConnectionError(f"the simulator gives no map: {answer.data[:200]!r}")
        return decode(Map, answer.data, encoding_of(answer.encoding, answer.data), strict=False)


def _print(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - what a script waits for


def _log(line: str) -> None:
    sys.stderr.write(line + "\n")
    sys.stderr.flush()
