"""A joystick on the network. The only file of it that knows zenoh.

One loop: what the source wants, what the hand puts, what the grip asks. Questions wait on a thread of their own, or a
slow answer would silence the hand.
"""

from __future__ import annotations

import queue
import sys
import threading
import time
from contextlib import suppress
from typing import Final

import msgspec
import zenoh

from intellwheels_agents.joystick.lease_client import LeaseClient
from intellwheels_agents.joystick.wish import Source
from intellwheels_agents.joystick.wish_timing import EVERY, WishTiming
from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Body, Clock, Result, Take, UserInput

ANSWER: Final = 1.5
"""Seconds an answer is waited for: less than a lease."""
LAST_ANSWER: Final = ANSWER + 1.0
"""Seconds until whoever asks says that there was none, and some for a busy machine."""


def operate(
    where: link.Link, agent: str, source: Source, *, take: bool, stop: threading.Event, retry_for: float | None
) -> int:
    """Put what a source wants until it ends or `stop` is set, and return the exit code: 0, or 1 when refused.

    Args:
        where: The link.
        agent: Whose user this is.
        source: What wants.
        take: Whether the simulator itself shall obey, by a lease.
        stop: Set when the process must end.
        retry_for: Seconds to look for a router or simulator; None for ever.
    """
    try:
        session = link.open_session(where, stop, timeout=retry_for, waiting=lambda why: _log(f"waiting why={why!r}"))
    except ConnectionError as error:
        _log(str(error))
        return 1
    if session is None:
        return 0
    with session:
        keys = Keys(where.world)
        inbox = link.Inbox()
        clock = session.declare_subscriber(keys.clock, inbox.on_sample)
        publisher = link.declare(session, keys.user(agent), CHANNELS["user"], Encoding.JSON)
        with publisher, clock:
            asker = _Asker(session, keys.ctl("take"))
            _look_for(session, keys.body(agent), agent, take=take)
            return _Loop(agent, source, asker, inbox, publisher, take=take).run(stop)


class _Asker:
    """Asks beside the loop."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._session = session
        self._key = key
        self.answers: queue.SimpleQueue[Result | None] = queue.SimpleQueue()

    def start(self, take: Take) -> None:
        """Ask; the answer comes into `answers`."""
        threading.Thread(target=lambda: self.answers.put(self.ask(take)), name="take", daemon=True).start()

    def ask(self, take: Take) -> Result | None:
        """Ask, and return the answer, or None when there was none."""
        try:
            answers = link.query(self._session, self._key, encode(take, Encoding.JSON), timeout=ANSWER)
            return decode(Result, answers[0].data, encoding_of(answers[0].encoding, answers[0].data), strict=False)
        except (ConnectionError, WireError) as error:
            _log(f"unanswered verb=take why={str(error)!r}")
            return None


class _Loop:
    """The life of a joystick."""

    def __init__(
        self, agent: str, source: Source, asker: _Asker, inbox: link.Inbox, publisher: zenoh.Publisher, *, take: bool
    ) -> None:
        self._agent = agent
        self._source = source
        self._asker = asker
        self._inbox = inbox
        self._publisher = publisher
        self._hand = WishTiming()
        self._lease = LeaseClient(agent) if take else None
        self._time: float | None = None

    def run(self, stop: threading.Event) -> int:
        lease = self._lease
        _tell(f"ready agent={self._agent}")
        try:
            while not stop.is_set():
                now = time.monotonic()
                self._hear()
                wish = self._source.wish(now, self._time)
                if wish is None:
                    break
                if lease is not None:
                    self._hold(lease, now)
                    if lease.lost:
                        _log(f"not taken agent={self._agent} why={lease.lost!r}")
                        return 1
                if lease is None or lease.lease is not None:
                    self._send(self._hand.put(wish, now))
                self._source.wait(EVERY)
        finally:
            self._end()
        return 0

    def _hold(self, lease: LeaseClient, now: float) -> None:
        take = lease.ask(now)
        if take is not None:
            self._asker.start(take)
        while True:
            try:
                result = self._asker.answers.get_nowait()
            except queue.Empty:
                return
            if lease.answered(result, now):
                _tell(f"taken agent={self._agent}")

    def _end(self) -> None:
        self._send(self._hand.off(time.monotonic()))
        if self._lease is not None and self._lease.is_asking:
            # A lease that is being granted is given back too.
            with suppress(queue.Empty):
                self._lease.answered(self._asker.answers.get(timeout=LAST_ANSWER), time.monotonic())
        back = None if self._lease is None else self._lease.back()
        if back is not None:
            result = self._asker.ask(back)
            if result is not None and result.code == "ok":
                _tell(f"released agent={self._agent}")
        _tell(f"ended agent={self._agent}")

    def _send(self, user: UserInput | None) -> None:
        if user is None:
            return
        if self._lease is not None:
            user = msgspec.structs.replace(user, lease=self._lease.lease)
        self._publisher.put(encode(user, Encoding.JSON))

    def _hear(self) -> None:
        for arrival in self._inbox.take():
            if isinstance(arrival, link.Put):
                try:
                    encoding = encoding_of(arrival.encoding, arrival.data)
                    self._time = decode(Clock, arrival.data, encoding, strict=False).time
                except WireError as error:
                    _log(f"dropped message=Clock why={error.text!r}")


def _look_for(session: zenoh.Session, key: str, agent: str, *, take: bool) -> None:
    """Say it when nobody has that name, or takes no user input: a put that nobody wants is silent."""
    try:
        answers = link.query(session, key, timeout=ANSWER)
        body = decode(Body, answers[0].data, encoding_of(answers[0].encoding, answers[0].data), strict=False)
    except (ConnectionError, WireError):
        _log(f"nobody agent={agent} yet")
        return
    if not take and not {"drive", "words"}.intersection(body.robot.user_input):
        _log(f"deaf agent={agent} why='its robot declares no driving by user input; --take drives it'")


def _tell(line: str) -> None:
    print(line, flush=True)  # noqa: T201 - what a script waits for


def _log(line: str) -> None:
    print(f"iw-joystick: {line}", file=sys.stderr, flush=True)  # noqa: T201 - the log
