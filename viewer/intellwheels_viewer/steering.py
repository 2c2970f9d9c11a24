"""A person's wishes, from one page, to the simulator.

Wishes are asked on a worker of the page, one after the other, and who asked hears in words why one was refused. Driving
is put once per message of the page and never repeated: release, a lost focus, a closed or a stalled page all mean stop.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Final, Protocol

from intellwheels_schemas.keys import Verb
from intellwheels_schemas.messages import Record, Result, Take, UserInput

LEASE: Final = 2.0
"""Seconds of a lease; renewed at half of it while the page drives."""
IDLE: Final = 1.5
"""Seconds after a release until the body is given back: before its lease ends by itself."""
STALL: Final = 0.3
"""Seconds without a message of the page after which the simulator stops the body by itself."""


class Refusal(Exception):  # noqa: N818  # what a user asked for was refused: no error of ours
    """A wish was not granted; the text says why, for people."""


class Simulator(Protocol):
    """What wishes are put to."""

    def ask(self, verb: Verb, wish: Record) -> Result:
        """Return the answer; waits. Raises `Refusal`."""

    def put_user(self, agent: str, wish: UserInput) -> None:
        """Put what a person wants; never waits."""


class Wishes:
    """The worker of one page.

    Args:
        simulator: Who is asked.
        refused: Gets words for the user when a wish was not granted.
    """

    def __init__(self, simulator: Simulator, refused: Callable[[str, str], None]) -> None:
        self._simulator, self._refused = simulator, refused
        self._worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="wishes")

    def ask(
        self,
        what: str,
        verb: Verb,
        wish: Record,
        done: Callable[[Result], None] | None = None,
        failed: Callable[[str], None] | None = None,
    ) -> None:
        """Ask for something and return at once.

        Args:
            what: Says in the notice what was refused: `Not placed`. Empty: nobody is told.
            verb: As the contract calls it.
            wish: Its message.
            done: Gets the answer when it was granted.
            failed: Gets the reason when it was not, before the user does.
        """
        self._worker.submit(self._ask, what, verb, wish, done, failed)

    def close(self) -> None:
        """Ask for nothing further; what was asked for is still said."""
        self._worker.shutdown(wait=False)

    def _ask(
        self,
        what: str,
        verb: Verb,
        wish: Record,
        done: Callable[[Result], None] | None,
        failed: Callable[[str], None] | None,
    ) -> None:
        try:
            result = self._simulator.ask(verb, wish)
        except Refusal as refusal:
            if failed is not None:
                failed(str(refusal))
            if what:
                self._refused(what, str(refusal))
            return
        if done is not None:
            done(result)


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
        self._until = 0.0
        self._asking = False
        self._moved = -math.inf
        self._sequence = 0
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
                if not self._asking and now > self._until - LEASE / 2:
                    self._take(agent)
            if self._lease is not None:
                self._sequence += 1
                wish = UserInput(lease=self._lease, seq=self._sequence, forward=forward, turn=turn)
                self._simulator.put_user(agent, wish)

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

    def _take(self, agent: str) -> None:
        self._asking = True

        def taken(result: Result) -> None:
            with self._lock:
                self._asking = False
                if self._closed or self._agent != agent:
                    self._give(agent, result.lease)
                else:
                    self._lease, self._until = result.lease, self._now() + LEASE

        def failed(_: str) -> None:
            with self._lock:
                self._asking = False
                # Not asked again with each message of a stick that is held.
                self._until = self._now() + LEASE
                self._lease = None

        self._wishes.ask("Not driven", "take", Take(agent=agent, lease=self._lease, seconds=LEASE), taken, failed)

    def _release(self) -> None:
        agent, lease = self._agent, self._lease
        self._agent = self._lease = None
        self._until, self._moved = 0.0, -math.inf
        if agent is not None and lease is not None:
            self._sequence += 1
            self._simulator.put_user(agent, UserInput(lease=lease, seq=self._sequence))
            self._give(agent, lease)

    def _give(self, agent: str, lease: str | None) -> None:
        # A lease that has just ended, or a body that has gone, is given back already.
        self._wishes.ask("", "take", Take(agent=agent, lease=lease, seconds=0.0))
