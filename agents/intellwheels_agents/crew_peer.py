"""A crew on the network: many agents of one process with one session.

Zenoh calls back on its own threads. A callback stores what arrived and returns. Only the main loop calls the harnesses
and their minds. No single wait is longer than `SLICE`, so that a signal is noticed.
"""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Sequence
from functools import partial
from typing import Any, Literal, NamedTuple

import zenoh

from intellwheels_agents.crew_harness import (
    AskBodyOf,
    CrewHarness,
    CrewMember,
    CrewOutput,
    RequestCrewJoin,
    RequestCrewLeave,
)
from intellwheels_agents.decision_watch import DecisionWatch
from intellwheels_agents.harness_outputs import AskClock, Exit, Log, Print, Publish
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
from intellwheels_schemas.crew_messages import CrewPart, split_measures
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.own_rights import denied, denied_join
from intellwheels_schemas.process import start_network_thread

REST_WAIT = 0.005
"""Seconds to wait for the other parts of the measures of a tick, so that they are answered with one message."""


class _Answered(NamedTuple):
    """What the simulator answered to a query about some agents, and why nobody did if that is known."""

    request: Literal["join", "clock", "body"]
    agents: tuple[str, ...]
    answers: list[link.Answer]
    denied: str = ""


def run_crew(
    crew: str,
    instance: str,
    members: Sequence[CrewMember],
    *,
    where: link.Link,
    encoding: Encoding,
    retry_for: float,
    stop: threading.Event,
) -> int:
    """Join with all agents, run their minds until `stop` is set or all have ended, leave, and return the exit code.

    Args:
        crew: Name of the crew.
        instance: 16 hex digits, new for each process, as in the robots.
        members: The agents.
        where: Which simulator to connect to, and how.
        encoding: The encoding of messages to the simulator, which answers in the same one.
        retry_for: Seconds to look for a simulator before giving up; may be infinite.
        stop: Set when the process must end.

    Raises:
        OptionError: A mind does not accept an option.
        ConnectionError: The options of `where` contradict each other.
    """

    def run(session: zenoh.Session, remaining: float) -> int:
        return _CrewPeer(session, crew, instance, members, where, encoding, remaining).run(stop)

    return run_in_session(where, retry_for, stop, run)


class _CrewPeer:
    """A crew's subscriptions, liveliness tokens and publisher, and its loop."""

    def __init__(
        self,
        session: zenoh.Session,
        crew: str,
        instance: str,
        members: Sequence[CrewMember],
        where: link.Link,
        encoding: Encoding,
        retry_for: float,
    ) -> None:
        self._session, self._crew, self._encoding, self._world = session, crew, encoding, where.world
        self._keys = keys = Keys(where.world)
        self._measures_key, self._error_key = keys.crew_measures(crew), keys.crew_error(crew)
        self._roles = {member.robot.name or "": member.robot.role for member in members}
        self._exit: int | None = None
        self._arrivals = Arrivals[_Answered]()
        self._watch = DecisionWatch(log)
        self._harness = CrewHarness(
            crew, instance, members, encoding=encoding, fetch_map=partial(fetch_map, session, keys),
            simulator=where.where(), retry_for=retry_for,
        )  # fmt: skip
        # The order prevents a race at joining: subscribe first, then declare the tokens, then ask.
        self._subscribers = [
            session.declare_subscriber(key, self._arrivals.store) for key in (self._measures_key, self._error_key)
        ]
        self._publisher = link.declare(session, keys.crew_actions(crew), CHANNELS["crew_actions"], encoding)
        self._tokens: list[Any] = [
            link.declare_token(session, keys.token(agent, role, instance, crew)) for agent, role in self._roles.items()
        ]
        self._simulator_token = session.liveliness().declare_subscriber(keys.alive, self._arrivals.notice, history=True)

    def run(self, stop: threading.Event) -> int:
        """Run until `stop` is set or the crew ends, and return the exit code."""
        harness = self._harness
        failed = True
        # Closed here and in order: a subscriber that is still open when Python exits makes it hang.
        with contextlib.ExitStack() as stack:
            for each in (self._simulator_token, *self._subscribers):
                stack.enter_context(each)
            for token in self._tokens:
                stack.callback(token.undeclare)
            stack.enter_context(self._publisher)
            stack.enter_context(self._watch)
            try:
                self._do(harness.start(time.monotonic()))
                while self._exit is None and not stop.is_set():
                    self._turn()
                failed = False
            finally:
                outputs = harness.stop()
                if failed:
                    # Remove the bodies at once instead of after the timeout, but print no "left" line: this is a crash.
                    outputs = [output for output in outputs if isinstance(output, RequestCrewLeave)]
                self._do(outputs)
                self._arrivals.report_dropped()
        return self._exit or 0

    def _turn(self) -> None:
        """Wait for arrivals or the harness's deadline, and handle what came."""
        harness = self._harness
        pause, deadline = SLICE, harness.deadline
        if deadline is not None:
            now = time.monotonic()
            if now >= deadline:
                self._do(harness.wake(now))
                return
            pause = min(SLICE, deadline - now)
        parts: dict[Encoding, list[CrewPart]] = {}
        try:
            arrival = self._arrivals.get(timeout=pause)
            self._watch.begin()
            while True:
                part = self._take(arrival, parts) if isinstance(arrival, zenoh.Sample) else None
                if isinstance(arrival, zenoh_inbox.Presence):
                    now = time.monotonic()
                    self._do(harness.present(now) if arrival.alive else harness.absent(now))
                elif isinstance(arrival, _Answered):
                    self._do(self._replied(arrival, time.monotonic()))
                # Parts come in order. Some may be lost.
                awaited = part is not None and part.part + 1 < part.parts
                arrival = self._arrivals.get(timeout=REST_WAIT) if awaited else self._arrivals.get_nowait()
        except queue.Empty:
            pass
        for encoding, some in parts.items():
            self._do(harness.measured(some, encoding))
        self._watch.end()

    def _take(self, sample: zenoh.Sample, parts: dict[Encoding, list[CrewPart]]) -> CrewPart | None:
        """Handle a sample; add measures to `parts` and return them."""
        if sample.kind != zenoh.SampleKind.PUT:
            return None
        key, data = str(sample.key_expr), sample.payload.to_bytes()
        try:
            encoding = encoding_of(str(sample.encoding), data)
            if key == self._measures_key:
                part = split_measures(data, encoding)
                parts.setdefault(encoding, []).append(part)
                return part
        except WireError as error:
            log(f"dropped key={key} why={error.text!r}")
            return None
        if key == self._error_key:
            self._do(self._harness.erred((data, encoding), time.monotonic()))
        return None

    def _do(self, outputs: list[CrewOutput]) -> None:
        keys = self._keys
        for output in outputs:
            if isinstance(output, Publish):
                self._publisher.put(output.payload)
            elif isinstance(output, RequestCrewJoin):
                self._ask("join", keys.crew_join(self._crew), output.payload, JOIN_TIMEOUT, output.agents)
            elif isinstance(output, AskClock):
                self._ask("clock", keys.clock, b"", CONFIRM_TIMEOUT)
            elif isinstance(output, AskBodyOf):
                self._ask("body", keys.body(output.agent), b"", CONFIRM_TIMEOUT, (output.agent,))
            elif isinstance(output, RequestCrewLeave):
                leave(self._session, keys.crew_leave(self._crew), output.payload, self._encoding)
            elif isinstance(output, Print):
                print(output.line, flush=True)  # noqa: T201 - scripts wait for these lines
            elif isinstance(output, Log):
                log(output.line)
            elif isinstance(output, Exit):
                self._exit = output.code

    def _ask(
        self,
        request: Literal["join", "clock", "body"],
        key: str,
        payload: bytes,
        timeout: float,
        agents: tuple[str, ...] = (),
    ) -> None:
        """Query in a thread of its own, as a crew must keep answering ticks meanwhile; the answers will arrive."""

        def query() -> None:
            answers = ask(self._session, self._keys, key, payload, self._encoding, timeout)
            why = ""
            if request == "join" and not any(answer.ok for answer in answers):
                with contextlib.suppress(zenoh.ZError):
                    why = self._denied(key, agents, sure=bool(answers))
            self._arrivals.put(_Answered(request, agents, [] if why else answers, why))

        start_network_thread(request, query)

    def _denied(self, key: str, agents: Sequence[str], *, sure: bool) -> str:
        """Return in words that this session may not join so; empty if it may, or if nobody knows."""
        asks = [partial(denied_join, self._session, self._world, self._roles[agent], agent) for agent in agents[:1]]
        return next(
            (why for ask in (partial(denied, self._session, key, "query"), *asks) if (why := ask(sure=sure))), ""
        )

    def _replied(self, arrival: _Answered, now: float) -> list[CrewOutput]:
        harness, answers = self._harness, arrival.answers
        if arrival.request == "body":
            return harness.bodied(arrival.agents[0], any(answer.ok for answer in answers))
        if arrival.request == "clock":
            clocks = [(answer.data, encoding_of(answer.encoding, answer.data)) for answer in answers if answer.ok]
            return harness.clocked(clocks)
        if not answers:
            return harness.unanswered(arrival.agents, now, arrival.denied)
        answer = answers[0]
        try:
            payload = answer.data, encoding_of(answer.encoding, answer.data)
        except WireError as error:
            log(f"dropped reply=join why={error.text!r}")
            return harness.unanswered(arrival.agents, now)
        take = harness.joined if answer.ok else harness.refused
        return take(payload, arrival.agents, now)
