"""Requests and driving commands of one page.

A worker of the page sends its requests one after the other and reports why one was refused. Driving commands are
published once per message of the page and never repeated, so releasing the stick, losing the focus, closing the page
and a page that hangs all stop the chair.
"""

from __future__ import annotations

import math
import queue
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import Goal, Record, Result, Take, UserInput
from intellwheels_schemas.process import start_network_thread

LEASE: Final = 6.0
"""Seconds of a lease. It is renewed at half of it while the page drives."""
IDLE: Final = 2.0
"""Seconds after the stick was released until the lease is given up; less than the lease itself."""
HELD: Final = 0.5
"""Seconds after the newest message of a moved stick for which the page says that it drives: five messages (chosen)."""
RETRY_AFTER: Final = 1.0
"""Seconds after a refusal until a stick that is still held asks again."""
VIEW_ONLY: Final = "View only"
"""Begins every notice about a missing right to control the simulation."""


class Refusal(Exception):  # noqa: N818  # a refused request is not an error of ours
    """A request was refused. The text says why, for people."""


class Simulator(Protocol):
    """Takes requests."""

    def ask(self, verb: Verb, request: Record) -> Result:
        """Return the answer. Blocks. Raises `Refusal`."""

    def put_user(self, agent: str, request: UserInput) -> None:
        """Publish a user's input. Never blocks."""


@dataclass(frozen=True)
class _Pending:
    """A request that waits for its turn."""

    what: str | None
    verb: Verb
    request: Record
    done: Callable[[Result], None] | None
    failed: Callable[[str], None] | None


class RequestQueue:
    """The requests of one page, sent in order by a worker thread.

    Args:
        simulator: Takes the requests.
        refused: Called with a title and a reason when a request was refused.
    """

    def __init__(self, simulator: Simulator, refused: Callable[[str, str], None]) -> None:
        self._simulator, self._refused = simulator, refused
        self._waiting: queue.SimpleQueue[_Pending | None] = queue.SimpleQueue()
        self._worker = start_network_thread("wishes", self._work, end=self.close)

    def ask(
        self,
        what: str | None,
        verb: Verb,
        request: Record,
        done: Callable[[Result], None] | None = None,
        failed: Callable[[str], None] | None = None,
    ) -> None:
        """Queue a request and return at once.

        Args:
            what: Title of the notice if it is refused, such as `Not placed`. None: no notice is shown.
            verb: The verb of the contract.
            request: Its message.
            done: Called with the answer if it was granted.
            failed: Called with the reason if it was refused, before the notice is shown.
        """
        self._waiting.put(_Pending(what, verb, request, done, failed))

    def close(self) -> None:
        """Accept no more requests. Queued ones are still sent, and so are those that their answers cause."""
        self._waiting.put(None)

    def join(self, seconds: float) -> None:
        """Wait after `close` until all requests were sent, at most this many seconds."""
        self._worker.join(seconds)

    def _work(self) -> None:
        open_ = True
        while open_ or not self._waiting.empty():
            asking = self._waiting.get()
            if asking is None:
                open_ = False
            else:
                try:
                    self._ask(asking)
                except Exception:  # a bug in one callback must not lose the requests after it
                    traceback.print_exc()

    def _ask(self, asking: _Pending) -> None:
        try:
            result = self._simulator.ask(asking.verb, asking.request)
        except Refusal as refusal:
            if asking.failed is not None:
                asking.failed(str(refusal))
            if asking.what is not None:
                self._refused(asking.what, str(refusal))
            return
        if asking.done is not None:
            asking.done(result)


class Driving:
    """Driving from one page: the lease of a body and the position of the stick.

    `stick` is called in the order of the page's messages, `tick` regularly by the drawing thread.

    Args:
        simulator: Takes the inputs.
        requests: Takes the requests for the lease.
        now: A monotonic clock, in seconds.
    """

    def __init__(self, simulator: Simulator, requests: RequestQueue, now: Callable[[], float] = time.monotonic) -> None:
        self._simulator, self._requests, self._now = simulator, requests, now
        self._lock = threading.Lock()
        self._agent: str | None = None
        self._lease: str | None = None
        self._until = -math.inf
        self._asking = False
        self._moved = -math.inf
        self._sequence = 0
        # Counts releases, so that an answer to a request from before a release is recognised.
        self._held = 0
        self._closed = False

    @property
    def agent(self) -> str | None:
        """The agent that the page drives, or has asked to drive."""
        return self._agent

    @property
    def driven(self) -> str | None:
        """The agent that the stick moves now, or has moved within the last `HELD` seconds; None without a lease."""
        with self._lock:
            return self._agent if self._lease is not None and self._now() - self._moved <= HELD else None

    def stick(self, agent: str | None, forward: float, turn: float) -> None:
        """Take one stick message of the page.

        Args:
            agent: The selected agent. A change releases the previous one.
            forward: In [-1, 1], clipped; NaN or infinity counts as a release.
            turn: The same, positive to the left.
        """
        if not (math.isfinite(forward) and math.isfinite(turn)):
            forward = turn = 0.0
        forward, turn = min(max(forward, -1.0), 1.0), min(max(turn, -1.0), 1.0)
        with self._lock:
            if agent != self._agent:
                self._release()
                self._agent = agent
            if agent is None or self._closed:
                return
            now = self._now()
            moves = forward != 0.0 or turn != 0.0
            if moves:
                self._moved = now
                if now >= self._until:
                    self._lease = None  # expired; a new one is needed
                if not self._asking and now > self._until - LEASE / 2:
                    self._take(agent, now)
            if self._lease is not None:
                self._sequence += 1
                request = UserInput(lease=self._lease, seq=self._sequence, forward=forward, turn=turn)
                self._simulator.put_user(agent, request)

    def go(self, agent: str, goal: Goal) -> None:
        """Send an agent's mind a goal.

        The goal is published after the body was taken and released. A publication is not answered, so taking the body
        first shows whether the goal would be refused. Under the lease, the release could overtake the goal.

        Args:
            agent: The agent.
            goal: The goal, in metres.
        """

        def given(_: Result) -> None:
            self._simulator.put_user(agent, UserInput(goal=goal))

        def taken(result: Result) -> None:
            give = Take(agent=agent, lease=result.lease, seconds=0.0)
            self._requests.ask("No goal set", "take", give, given)

        with self._lock:
            self._release()  # sent by the same worker, so it comes first
            self._requests.ask("No goal set", "take", Take(agent=agent, seconds=LEASE), taken)

    def tick(self) -> None:
        """Release a body that has not been driven for a while."""
        with self._lock:
            if self._lease is not None and self._now() - self._moved > IDLE:
                self._release()

    def close(self) -> None:
        """The page was closed: publish nothing more and release the body."""
        with self._lock:
            self._closed = True
            self._release()

    def _take(self, agent: str, now: float) -> None:
        self._asking = True
        held = self._held

        def taken(result: Result) -> None:
            with self._lock:
                self._asking = False
                if held != self._held:
                    self._give_back(agent, result.lease)
                else:
                    # Counted from the request, so it expires here before it does at the simulator.
                    self._lease, self._until = result.lease, now + LEASE

        def failed(_: str) -> None:
            with self._lock:
                self._asking = False
                if held == self._held:
                    # Do not ask again with every message of a stick that is held.
                    self._until = self._now() + LEASE / 2 + RETRY_AFTER
                    self._lease = None

        self._requests.ask("Cannot drive", "take", Take(agent=agent, lease=self._lease, seconds=LEASE), taken, failed)

    def _release(self) -> None:
        agent, lease = self._agent, self._lease
        self._agent = self._lease = None
        self._until = self._moved = -math.inf
        self._held += 1
        if agent is not None and lease is not None:
            self._sequence += 1
            self._simulator.put_user(agent, UserInput(lease=lease, seq=self._sequence))
            self._give_back(agent, lease)

    def _give_back(self, agent: str, lease: str | None) -> None:
        # A refusal means that the lease has expired or the body has left: nothing to report.
        self._requests.ask(None, "take", Take(agent=agent, lease=lease, seconds=0.0))
