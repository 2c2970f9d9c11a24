"""The check's simulator on the network and the program's process. The only file of the check that knows the link.

The process is a group of its own, so that whatever the command starts ends with it. What Zenoh's threads bring goes
into an inbox; a simulator that goes closes its session, as one that crashed would, and its inbox goes with it.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import tempfile
import threading
import time
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from types import TracebackType
from typing import IO, Final, Literal, Self

from intellwheels_experiments.conformance.contract_points import Acted, Asked, Ended, Left, News, Seen
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.link import (
    Arrival,
    Ask,
    Inbox,
    Link,
    Presence,
    Put,
    declare,
    declare_token,
    open_session,
    watch_tokens,
)
from intellwheels_schemas.messages import Map, Result

SLICE: Final = 0.05
"""Seconds of one wait; between two the process is looked at."""
GONE: Final = 3.0
"""Seconds that the tokens of a process that was killed may stay."""
PRINTED: Final = 64 * 1024
"""Bytes of its output that are looked at."""


class NetworkProbe:
    """A `Stand` of a real process and a real session. Leaving the `with` ends both.

    Args:
        command: The program and its arguments.
        environment: What it gets beside this process's own.
        link: Where to listen, or which router to meet at, and the world.
        agent: The program's name.
        floor: What a program is given that asks for the map.
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
        self._environment = {**os.environ, **environment}
        self._link = link
        self._agent = agent
        self._keys = Keys(link.world)
        self._floor = floor
        self._stop = stop
        self._simulator: _Simulator | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._ended = False
        self._output: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 - closed by __exit__
        self._tokens: set[str] = set()
        self._news: deque[News] = deque()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._kill()
        self.fall()
        self._output.close()

    def now(self) -> float:
        """Return seconds of a monotonic clock."""
        return time.monotonic()

    # ------------------------------------------------------------ the program

    def start(self) -> None:
        """Start the program.

        Raises:
            OSError: It cannot be started.
        """
        self._output.seek(0)
        self._output.truncate()
        self._ended = False
        self._process = subprocess.Popen(
            self._command,
            stdin=subprocess.DEVNULL,
            stdout=self._output,
            stderr=subprocess.STDOUT,
            process_group=0,
            env=self._environment,
        )

    def interrupt(self) -> None:
        """Tell the program to end: SIGTERM to all its processes."""
        self._signal(signal.SIGTERM)

    def end(self) -> None:
        """Kill the program, and wait until its token is gone."""
        self._kill()
        deadline = self.now() + GONE
        while self._simulator is not None and self._tokens and self.now() < deadline:
            self._gather(SLICE)
        self._gather(0.0)
        self._news.clear()

    def printed(self) -> str:
        """Return what the program printed since its start."""
        # The place in the file is the program's too, so it is not moved.
        size = os.fstat(self._output.fileno()).st_size
        start = max(0, size - PRINTED)
        return os.pread(self._output.fileno(), size - start, start).decode("utf-8", "backslashreplace")

    def _kill(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            # The leader may be gone and others of its group not.
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait(timeout=GONE)

    def _signal(self, number: signal.Signals) -> None:
        if self._process is not None and self._process.poll() is None:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, number)

    # ------------------------------------------------------------ the simulator

    def rise(self) -> None:
        """Be there.

        Raises:
            ConnectionError: The port is taken, the router does not answer, or this process must end.
        """
        if self._simulator is None:
            self._simulator = _Simulator(self._link, self._keys, self._agent, self._stop)

    def fall(self) -> None:
        """Be gone."""
        if self._simulator is not None:
            self._simulator.close()
            self._simulator = None
        self._tokens.clear()
        self._news.clear()

    def put(self, kind: Literal["measures", "error"], data: bytes, encoding: Encoding) -> None:
        """Put something for the program; nothing when the simulator is gone."""
        if self._simulator is not None:
            self._simulator.put(kind, data, encoding)

    def wait(self, seconds: float) -> News | None:
        """Return what happened next.

        Raises:
            ConnectionError: This process must end.
        """
        deadline = self.now() + seconds
        while not self._news and (left := deadline - self.now()) > 0.0:
            if self._stop.is_set():
                raise ConnectionError("told to stop before the check was over")
            self._gather(min(SLICE, left))
        return self._news.popleft() if self._news else None

    def _gather(self, seconds: float) -> None:
        """Turn what arrives within so many seconds into news."""
        ended = self._process is not None and not self._ended and self._process.poll() is not None
        if self._simulator is not None:
            for arrival in self._simulator.take(seconds):
                self._take(arrival)
        else:
            self._stop.wait(seconds)
        # Last: what it put before its end came before.
        if ended and self._process is not None:
            self._ended = True
            self._news.append(Ended(self._process.returncode))

    def _take(self, arrival: Arrival) -> None:
        if isinstance(arrival, Put):
            if arrival.key == self._keys.actions(self._agent):
                self._news.append(Acted(arrival.data, arrival.encoding))
        elif isinstance(arrival, Presence):
            token = self._keys.parse_token(arrival.key)
            if token is not None and token.agent == self._agent:
                (self._tokens.add if arrival.alive else self._tokens.discard)(arrival.key)
                self._news.append(Seen(token.role, token.instance, arrival.alive))
        elif isinstance(arrival, Ask):
            self._replied(arrival)

    def _replied(self, ask: Ask) -> None:
        try:
            encoding = encoding_of(ask.encoding, ask.data) if ask.encoding else Encoding.JSON
        except WireError:
            encoding = Encoding.JSON
        if ask.key == self._keys.join(self._agent):

            def answer(data: bytes, encoding: Encoding, granted: bool) -> None:
                (ask.reply if granted else ask.refuse)(data, encoding)
                ask.close()

            self._news.append(Asked(ask.data, ask.encoding, answer))
        elif ask.key == self._keys.leave(self._agent):
            ask.reply(encode(Result(code="ok"), encoding), encoding)
            ask.close()
            self._news.append(Left())
        elif ask.key == self._keys.map:
            ask.reply(encode(self._floor, encoding), encoding)
            ask.close()


class _Simulator:
    """What an agent sees of a simulator: presence, queries answered, measures.

    Raises:
        ConnectionError: The port is taken, the router does not answer, or this process must end.
    """

    def __init__(self, link: Link, keys: Keys, agent: str, stop: threading.Event) -> None:
        session = open_session(link, stop, timeout=20.0)
        if session is None:
            raise ConnectionError("told to stop before the check was over")
        self._inbox = Inbox()
        with ExitStack() as stack:
            stack.enter_context(session)
            stack.enter_context(watch_tokens(session, keys.tokens(agent), self._inbox))
            stack.enter_context(session.declare_subscriber(keys.actions(agent), self._inbox.on_sample))
            for key in (keys.join(agent), keys.leave(agent), keys.map):
                stack.enter_context(session.declare_queryable(key, self._inbox.on_query))
            self._publishers = {
                kind: stack.enter_context(declare(session, keys.out(agent, kind), CHANNELS[kind], encoding))
                for encoding in (Encoding.JSON,)
                for kind in _KINDS
            }
            stack.enter_context(declare_token(session, keys.alive))
            self._stack = stack.pop_all()

    def put(self, kind: Literal["measures", "error"], data: bytes, encoding: Encoding) -> None:
        self._publishers[kind].put(data, encoding=encoding.value)

    def take(self, seconds: float) -> list[Arrival]:
        self._inbox.wait(seconds)
        return self._inbox.take()

    def close(self) -> None:
        self._stack.close()


_KINDS: Final[tuple[Literal["measures", "error"], ...]] = ("measures", "error")
