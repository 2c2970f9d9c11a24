"""The check's simulator on the network, and the program's process. The only file of the check that knows the link.

What Zenoh's threads receive goes into an inbox. A simulator that disappears closes its session, as a crashed one would,
and its inbox goes with it.
"""

from __future__ import annotations

import contextlib
import signal
import tempfile
import threading
import time
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Final, Literal, Self

import zenoh

from intellwheels_experiments.conformance.probe import (
    NO_CREWS,
    ActionsPut,
    CrewRequest,
    JoinRequest,
    LeaveRequest,
    ProgramEvent,
    ProgramExit,
    TokenChange,
)
from intellwheels_experiments.run.child_processes import ChildProcesses
from intellwheels_experiments.run.foreign_program import guarded
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.link import Link, declare, declare_token, open_session, watch_tokens
from intellwheels_schemas.messages import Clock, Map, Measures, Refused, Result
from intellwheels_schemas.own_rights import denied_service
from intellwheels_schemas.zenoh_inbox import Arrival, Ask, Inbox, Presence, Put

SLICE: Final = 0.05
"""Seconds of one wait for the network. Between two waits the check looks at the process."""
OPEN_LIMIT: Final = 20.0
"""Seconds to open the session."""
TOKENS_GONE: Final = 3.0
"""Seconds for which the tokens of a killed process may remain."""
OUTPUT_LIMIT: Final = 64 * 1024
"""Bytes at the end of the program's output that are read."""

_STOPPED: Final = "stopped before the check was complete"


class NetworkProbe:
    """A `Probe` of a real process and a real session. Leaving the `with` ends both.

    Args:
        command: The program and its arguments.
        environment: Variables to add to those of this process.
        link: The world, and where to listen or which router to connect to.
        agent: The program's name.
        floor: The answer for a program that asks for the map.
        stop: Set when this process must end.
    """

    def __init__(
        self,
        command: Sequence[str],
        environment: Mapping[str, str],
        link: Link,
        agent: str,
        floor: Map,
        stop: threading.Event,
    ) -> None:
        self._command = list(command)
        self._environment = environment
        self._link = link
        self._agent = agent
        self._keys = Keys(link.world)
        self._floor = floor
        self._stop = stop
        self._stack = ExitStack()
        logs = self._stack.enter_context(tempfile.TemporaryDirectory(prefix="iw-check-agent-"))
        self._children = self._stack.enter_context(ChildProcesses(Path(logs)))
        self._program: str | None = None
        self._exit_told = False
        self._simulator: _Simulator | None = None
        self._last: tuple[bytes, Encoding] | None = None
        self._tokens: set[str] = set()
        self._events: deque[ProgramEvent] = deque()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._kill()
        self.stop_simulator()
        self._stack.close()

    def now(self) -> float:
        """Return the seconds of a monotonic clock."""
        return time.monotonic()

    # ------------------------------------------------------------ the program

    def start_program(self) -> None:
        """Start the program, with the guard that ends it if this process is killed.

        Raises:
            OSError: The guard cannot be started.
        """
        command = guarded(self._command, Path.cwd())
        self._program = self._children.launch("program", command, self._environment, merge_errors=True)
        self._exit_told = False

    def interrupt_program(self) -> None:
        """Send SIGTERM to the program and to what it started."""
        self._signal(signal.SIGTERM)

    def kill_program(self) -> None:
        """Kill the program, and wait until its tokens are gone."""
        self._kill()
        deadline = self.now() + TOKENS_GONE
        while self._simulator is not None and self._tokens and self.now() < deadline:
            self._gather(SLICE)
        self._gather(0.0)
        self._events.clear()
        if self._simulator is not None:
            self._simulator.blocks = False

    def output(self) -> str:
        """Return what the program printed since its start, on standard output and standard error."""
        if self._program is None:
            return ""
        return self._children.log_of(self._program).read_bytes()[-OUTPUT_LIMIT:].decode("utf-8", "backslashreplace")

    def _kill(self) -> None:
        if self._program is not None and not self._exit_told:
            self._signal(signal.SIGKILL)
            self._children.exit(self._program)
            self._exit_told = True

    def _signal(self, number: signal.Signals) -> None:
        if self._program is not None and self._program in self._children.running:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                self._children.signal(self._program, number)

    # ------------------------------------------------------------ the simulator

    def start_simulator(self) -> None:
        """Make the simulator present. Does nothing if it is.

        Raises:
            ConnectionError: The port is in use, the router does not answer, or this process must end.
        """
        if self._simulator is None:
            self._simulator = _Simulator(self._link, self._keys, self._agent, self._stop)

    def stop_simulator(self) -> None:
        """Make the simulator disappear with its connections."""
        if self._simulator is not None:
            self._simulator.close()
            self._simulator = None
        self._tokens.clear()
        self._events.clear()

    def put(self, kind: Literal["measures", "error"], data: bytes, encoding: Encoding) -> None:
        """Publish a message for the program. Without a simulator nothing happens."""
        if kind == "measures":
            self._last = data, encoding
        if self._simulator is not None:
            self._simulator.put(kind, data, encoding)

    def next_event(self, timeout: float) -> ProgramEvent | None:
        """Return the next event, or None if there is none within `timeout` seconds.

        Raises:
            ConnectionError: This process must end.
        """
        deadline = self.now() + timeout
        while not self._events and (left := deadline - self.now()) > 0.0:
            if self._stop.is_set():
                raise ConnectionError(_STOPPED)
            self._gather(min(SLICE, left))
        return self._events.popleft() if self._events else None

    def _gather(self, seconds: float) -> None:
        """Turn what arrives within some seconds into events."""
        self._children.receive()
        exited = self._children.exited(self._program) if self._program is not None and not self._exit_told else None
        if self._simulator is not None:
            for arrival in self._simulator.take(seconds):
                self._take(arrival)
        else:
            self._stop.wait(seconds)
        # Last, because everything that the program put came before its end.
        if exited is not None:
            self._exit_told = True
            self._events.append(ProgramExit(exited.code))

    def _take(self, arrival: Arrival) -> None:
        if isinstance(arrival, Put):
            if arrival.key == self._keys.actions(self._agent):
                blocks = self._simulator is not None and self._simulator.blocks
                self._events.append(ActionsPut(arrival.data, arrival.encoding, blocks))
        elif isinstance(arrival, Presence):
            token = self._keys.parse_token(arrival.key)
            if token is not None and token.agent == self._agent:
                (self._tokens.add if arrival.alive else self._tokens.discard)(arrival.key)
                self._events.append(TokenChange(token.role, token.instance, arrival.alive))
        elif isinstance(arrival, Ask):
            self._reply(arrival)

    def _clock(self) -> Clock | None:
        """Return the clock of the Measures that were put last."""
        if self._last is None:
            return None
        measures = decode(Measures, *self._last, strict=False)  # one point puts fields that nobody knows
        return Clock(
            run=measures.run, tick=measures.tick, time=measures.time, state="running", pace="lockstep",
            hash="0" * 16, stamp=time.time(),
        )  # fmt: skip

    def _reply(self, ask: Ask) -> None:
        try:
            encoding = encoding_of(ask.encoding, ask.data) if ask.encoding else Encoding.JSON
        except WireError:
            encoding = Encoding.JSON
        if ask.key == self._keys.join(self._agent):

            def answer(data: bytes, encoding: Encoding, granted: bool) -> None:
                (ask.reply if granted else ask.refuse)(data, encoding)
                ask.close()

            self._events.append(JoinRequest(ask.data, ask.encoding, answer))
        elif ask.key == self._keys.leave(self._agent):
            ask.reply(encode(Result(code="ok"), encoding), encoding)
            ask.close()
            self._events.append(LeaveRequest())
        elif (asked := self._keys.parse_crew_query(ask.key)) is not None:
            refused = Refused(code="value", text=f"{NO_CREWS}; crew '{asked.crew}' asked to join")
            ask.refuse(encode(refused, encoding), encoding)
            ask.close()
            self._events.append(CrewRequest(asked.crew))
        elif ask.key == self._keys.clock:
            if (clock := self._clock()) is not None:
                ask.reply(encode(clock, encoding), encoding)
            ask.close()
        elif ask.key == self._keys.map:
            ask.reply(encode(self._floor, encoding), encoding)
            ask.close()


class _Simulator:
    """The agent's view of a simulator: its presence, its answers to queries, and Measures.

    Attributes:
        blocks: Whether a program has put Actions that block, since this was last reset.

    Raises:
        ConnectionError: The port is in use, the router does not answer, or this process must end.
    """

    def __init__(self, link: Link, keys: Keys, agent: str, stop: threading.Event) -> None:
        session = open_session(link, stop, timeout=OPEN_LIMIT)
        if session is None:
            raise ConnectionError(_STOPPED)
        self._inbox = Inbox()
        self.blocks = False
        with ExitStack() as stack:
            stack.enter_context(session)
            if denied := denied_service(session, link.world):
                raise ConnectionError(denied)
            stack.enter_context(watch_tokens(session, keys.tokens(agent), self._inbox))
            stack.enter_context(session.declare_subscriber(keys.actions(agent), self._on_actions))
            for key in (keys.join(agent), keys.leave(agent), keys.every_crew_join, keys.map, keys.clock):
                stack.enter_context(session.declare_queryable(key, self._inbox.on_query))
            self._publishers = {
                kind: stack.enter_context(declare(session, keys.out(agent, kind), CHANNELS[kind], Encoding.JSON))
                for kind in _KINDS
            }
            stack.enter_context(declare_token(session, keys.alive))
            self._stack = stack.pop_all()

    def put(self, kind: Literal["measures", "error"], data: bytes, encoding: Encoding) -> None:
        self._publishers[kind].put(data, encoding=encoding.value)

    def _on_actions(self, sample: zenoh.Sample) -> None:
        # Zenoh calls this on a thread of its own. A flag that is set too early only names the fault too early.
        if sample.congestion_control != zenoh.CongestionControl.DROP:
            self.blocks = True
        self._inbox.on_sample(sample)

    def take(self, seconds: float) -> list[Arrival]:
        self._inbox.wait(seconds)
        return self._inbox.take()

    def close(self) -> None:
        self._stack.close()


_KINDS: Final[tuple[Literal["measures", "error"], ...]] = ("measures", "error")
