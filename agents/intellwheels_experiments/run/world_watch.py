"""Watches a running world. The only file of `run` on the network.

Zenoh's threads put what arrives into an inbox, and `drain` takes it from there. Whatever was lost on the way, events
above all, is queried at the end.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final, TypeVar

from intellwheels_experiments.run.run_record import RunRecord
from intellwheels_schemas.codec import decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys, Verb
from intellwheels_schemas.link import Answer, Link, open_session, query
from intellwheels_schemas.messages import Clock, Event, Events, Result, WorldState
from intellwheels_schemas.messages import Record as Message
from intellwheels_schemas.zenoh_inbox import Inbox, Put

if TYPE_CHECKING:
    import zenoh

ANSWER_LIMIT: Final = 2.0
"""Seconds a simulator has to answer."""

OPEN_LIMIT: Final = 20.0
"""Seconds to connect to a simulator that printed `ready`."""

_M = TypeVar("_M", bound=Message)


class WorldWatch:
    """Receives what a world publishes for viewers, and queries it.

    Args:
        session: An open session.
        world: The world to watch.
        subscribes: Whether it receives what is published. Otherwise it only queries.
    """

    def __init__(self, session: zenoh.Session, world: str, *, subscribes: bool = True) -> None:
        self._session = session
        self._keys = Keys(world)
        self._inbox = Inbox()
        # The record puts messages in order, so one inbox serves all keys.
        self._subscribers = [
            session.declare_subscriber(key, self._inbox.on_sample)
            for key in (self._keys.every_state, self._keys.event, self._keys.clock)
            if subscribes
        ]

    def close(self) -> None:
        """Receive nothing more."""
        for subscriber in self._subscribers:
            subscriber.undeclare()  # type: ignore[no-untyped-call]

    def drain(self, record: RunRecord) -> None:
        """Put what arrived since the last call into the record."""
        for arrival in self._inbox.take():
            if isinstance(arrival, Put):
                if arrival.key == self._keys.clock:
                    self._add(Clock, arrival.data, arrival.encoding, record.on_clock)
                elif arrival.key == self._keys.event:
                    self._add(Event, arrival.data, arrival.encoding, record.on_event)
                elif self._keys.parse_state(arrival.key) is not None:
                    self._add(WorldState, arrival.data, arrival.encoding, record.on_state)

    def query(self, record: RunRecord) -> None:
        """Ask the simulator for the events that were missed, and then for the state of all bodies."""
        asked = None
        # A run that began in between numbers its events from 0 again.
        while asked is None or record.run != asked:
            asked = record.run or ""
            for answer in self._ask(f"{self._keys.event}?since={record.next_missing}"):
                self._add(Events, answer.data, answer.encoding, record.on_events)
            if record.run is None:
                break
        for answer in self._ask(self._keys.every_state):
            self._add(WorldState, answer.data, answer.encoding, record.on_state)

    def query_all(self, record: RunRecord) -> None:
        """Ask the simulator for its clock, the present state and the events that were missed."""
        self.query(record)
        for answer in self._ask(self._keys.clock):
            self._add(Clock, answer.data, answer.encoding, record.on_clock)

    def control(self, verb: Verb, message: Message, timeout: float = ANSWER_LIMIT) -> Result:
        """Ask the simulator for a control verb and return its answer.

        Args:
            verb: The verb.
            message: Its document.
            timeout: Seconds to wait for the answer.

        Raises:
            ConnectionError: No answer came in time.
            WireError: The answer is not a `Result`.
        """
        answer = query(self._session, self._keys.ctl_of(verb, message), encode(message), timeout=timeout)[0]
        return decode(Result, answer.data, encoding_of(answer.encoding, answer.data), strict=False)

    def _ask(self, selector: str) -> list[Answer]:
        # A simulator that has just died does not answer. The record then keeps what was seen until then.
        with suppress(ConnectionError):
            answers = query(self._session, selector, timeout=ANSWER_LIMIT)
            return [answer for answer in answers if answer.ok]
        return []

    @staticmethod
    def _add(kind: type[_M], data: bytes, encoding: str, take: Callable[[_M], None]) -> None:
        # Others may write to the same keys, and a newer simulator may send more fields.
        with suppress(WireError):
            take(decode(kind, data, encoding_of(encoding, data), strict=False))


@contextmanager
def watching(link: Link, stop: threading.Event, *, subscribes: bool = True) -> Iterator[WorldWatch]:
    """Connect to a world and watch it until the `with` is left.

    Args:
        link: The world and how to reach it.
        stop: Set from outside to give up connecting.
        subscribes: Whether to receive what is published. Otherwise the watch only queries.

    Raises:
        ConnectionError: The world could not be reached in time, or `stop` was set.
    """
    session = open_session(link, stop, timeout=OPEN_LIMIT)
    if session is None:
        raise ConnectionError(f"stopped before {link.where()} answered")
    with session:
        watch = WorldWatch(session, link.world, subscribes=subscribes)
        try:
            yield watch
        finally:
            watch.close()
