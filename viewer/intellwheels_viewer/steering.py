"""A person's wishes, from one page, to the simulator.

Wishes are asked on a worker of the page, one after the other, and who asked hears in words why one was refused. Driving
is put once per message of the page and never repeated: release, a lost focus, a closed or a stalled page all mean stop.
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

LEASE: Final = 6.0
"""Seconds of a lease; renewed at half of it while the page drives."""
IDLE: Final = 2.0
"""Seconds after a release until the body is given back: before the lease is over by itself."""
AGAIN: Final = 1.0
"""Seconds after a refusal until a stick that is held asks again."""


class Refusal(Exception):  # noqa: N818  # what a user asked for was refused: no error of ours
    """A wish was not granted; the text says why, for people."""


class Simulator(Protocol):
    """What wishes are put to."""

    def ask(self, verb: Verb, wish: Record) -> Result:
        """Return the answer; waits. Raises `Refusal`."""

    def put_user(self, agent: str, wish: UserInput) -> None:
        """Put what a person wants; never waits."""


@dataclass(frozen=True)
class _Asking:
    """A wish that waits for its turn."""

    what: str | None
    verb: Verb
    wish: Record
    done: Callable[[Result], None] | None
    failed: Callable[[str], None] | None


class Wishes:
    """The worker of one page.

    Args:
        simulator: Who is asked.
        refused: Gets words for the user when a wish was not granted.
    """

    def __init__(self, simulator: Simulator, refused: Callable[[str, str], None]) -> None:
        self._simulator, self._refused = simulator, refused
        self._waiting: queue.SimpleQueue[_Asking | None] = queue.SimpleQueue()
        # A daemon: a simulator that does not answer holds no viewer that was told to stop.
        self._worker = threading.Thread(target=self._work, name="wishes", daemon=True)
        self._worker.start()

    def ask(
        self,
        what: str | None,
        verb: Verb,
        wish: Record,
        done: Callable[[Result], None] | None = None,
        failed: Callable[[str], None] | None = None,
    ) -> None:
        """Ask for something and return at once.

        Args:
            what: Says in the notice what was refused: `Not placed`; None: the user need not know.
            verb: As the contract calls it.
            wish: Its message.
            done: Gets the answer when it was granted.
            failed: Gets the reason when it was not, before the user does.
        """
        self._waiting.put(_Asking(what, verb, wish, done, failed))

    def close(self) -> None:
        """Ask for nothing further; what was asked for is still said, and what its answers ask for in their turn."""
        self._waiting.put(None)

    def join(self, seconds: float) -> None:
        """Wait until all is said after `close`, or so long."""
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
                except Exception:  # a fault of ours costs this wish, not those that come after it
                    traceback.print_exc()

    def _ask(self, asking: _Asking) -> None:
        try:
            result = self._simulator.ask(asking.verb, asking.wish)
        except Refusal as refusal:
            if asking.failed is not None:
                asking.failed(str(refusal))
            if asking.what is not None:
                self._refused(asking.what, str(refusal))
            return
        if asking.done is not None:
            asking.done(result)


class Driving:
    """A page's hand on a body: the lease, and what the stick says.

    `stick` is called in the order of the page's messages, `tick` now and then by the drawing thread.

    Args:
        simulator: Where inputs are put.
        wishes: Where the lease is asked for.
        now: A clock that goes on, in seconds.
    """

    def __init__(self, simulator: Simulator, wishes: Wishes, now: Callable[[], float] = time.monotonic) -> None:
        self._simulator, self._wishes, self._now = simulator, wishes, now
        self._lock = threading.Lock()
        self._agent: str | None = None
        self._lease: str | None = None
        self._until = -math.inf
        self._asking = False
        self._moved = -math.inf
        self._sequence = 0
        # Counts the releases: an answer to what was asked before one is for nobody.
        self._held = 0
        self._closed = False

    @property
    def agent(self) -> str | None:
        """Whom the page holds, or asks to hold."""
        return self._agent

    def stick(self, agent: str | None, forward: float, turn: float) -> None:
        """Take one message of the page.

        Args:
            agent: The one that is selected; another than before is a release of that.
            forward: In [-1, 1]; anything else is a stranger's and counts as release.
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
                    self._lease = None  # it is over, and must be taken anew
                if not self._asking and now > self._until - LEASE / 2:
                    self._take(agent, now)
            if self._lease is not None:
                self._sequence += 1
                wish = UserInput(lease=self._lease, seq=self._sequence, forward=forward, turn=turn)
                self._simulator.put_user(agent, wish)

    def go(self, agent: str, goal: Goal) -> None:
        """Tell an agent's mind where to go.

        It is put once the body was taken and given back: a put is not answered, so what would be refused is found out
        by what is. Under the lease itself it would race with the giving back, which may overtake a put.

        Args:
            agent: Whose mind.
            goal: Where, in metres.
        """

        def given(_: Result) -> None:
            self._simulator.put_user(agent, UserInput(goal=goal))

        def taken(result: Result) -> None:
            give = Take(agent=agent, lease=result.lease, seconds=0.0)
            self._wishes.ask("No goal set", "take", give, given)

        with self._lock:
            self._release()  # what it drove is given back by the same worker, so before
            self._wishes.ask("No goal set", "take", Take(agent=agent, seconds=LEASE), taken)

    def tick(self) -> None:
        """Give back what has not been driven for a while."""
        with self._lock:
            if self._lease is not None and self._now() - self._moved > IDLE:
                self._release()

    def close(self) -> None:
        """The page is gone: nothing is put any more, and the body is given back."""
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
                    self._give(agent, result.lease)
                else:
                    # Reckoned from the asking, it is over here before it is at the simulator.
                    self._lease, self._until = result.lease, now + LEASE

        def failed(_: str) -> None:
            with self._lock:
                self._asking = False
                if held == self._held:
                    # Not asked again with each message of a stick that is held.
                    self._until = self._now() + LEASE / 2 + AGAIN
                    self._lease = None

        self._wishes.ask("Not driven", "take", Take(agent=agent, lease=self._lease, seconds=LEASE), taken, failed)

    def _release(self) -> None:
        agent, lease = self._agent, self._lease
        self._agent = self._lease = None
        self._until = self._moved = -math.inf
        self._held += 1
        if agent is not None and lease is not None:
            self._sequence += 1
            self._simulator.put_user(agent, UserInput(lease=lease, seq=self._sequence))
            self._give(agent, lease)

    def _give(self, agent: str, lease: str | None) -> None:
        # Refused when it is over already, or the body gone: all the same to who let go.
        self._wishes.ask(None, "take", Take(agent=agent, lease=lease, seconds=0.0))
