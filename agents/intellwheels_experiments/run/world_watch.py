"""The watch on a running world. The only file of this package on the network.

Zenoh's threads put what arrives into an inbox; `pour` takes it from there. What was lost on the
way, events above all, is asked for at the end.
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
from intellwheels_schemas.link import Answer, Inbox, Link, Put, open_session, query
from intellwheels_schemas.messages import Clock, Event, Events, Result, WorldState
from intellwheels_schemas.messages import Record as Message

if TYPE_CHECKING:
    import zenoh

ANSWER_LIMIT: Final = 2.0
"""Seconds a simulator has to answer."""

OPEN_LIMIT: Final = 20.0
"""Seconds to be connected to a simulator that said that it is ready."""

_M = TypeVar("_M", bound=Message)


class WorldWatch:
    """What sees a run from outside; it is told everything any viewer is told.

    Args:
        session: An open session.
        world: The world to watch.
        listens: Whether it hears what is published; else it only asks.
    """

    def __init__(self, session: zenoh.Session, world: str, *, listens: bool = True) -> None:
        self._session = session
        self._keys = Keys(world)
        self._inbox = Inbox()
        # Names in (Run, Tick) order are the record's business, so one inbox does for all.
        self._subscribers = [
            session.declare_subscriber(key, self._inbox.on_sample)
            for key in (self._keys.every_state, self._keys.event, self._keys.clock)
            if listens
        ]

    def close(self) -> None:
        """Hear nothing further."""
        for subscriber in self._subscribers:
            subscriber.undeclare()  # type: ignore[no-untyped-call]

    def pour(self, record: RunRecord) -> None:
        """Put what arrived since the last time into the record."""
        for arrival in self._inbox.take():
            if isinstance(arrival, Put):
                if arrival.key == self._keys.clock:
                    self._give(Clock, arrival.data, arrival.encoding, record.on_clock)
                elif arrival.key == self._keys.event:
                    self._give(Event, arrival.data, arrival.encoding, record.on_event)
                elif self._keys.parse_state(arrival.key) is not None:
                    self._give(WorldState, arrival.data, arrival.encoding, record.on_state)

    def look(self, record: RunRecord) -> None:
        """Ask the simulator for events that were not seen, and then for the state of all bodies."""
        asked = None
        # The numbers of a run that began in between start anew.
        while asked is None or record.run != asked:
            asked = record.run or ""
            for answer in self._ask(f"{self._keys.event}?since={record.wanted}"):
                self._give(Events, answer.data, answer.encoding, record.on_events)
            if record.run is None:
                break
        for answer in self._ask(self._keys.every_state):
            self._give(WorldState, answer.data, answer.encoding, record.on_state)

    def complete(self, record: RunRecord) -> None:
        """Ask the simulator for what is true now and for events that were not seen."""
        self.look(record)
        for answer in self._ask(self._keys.clock):
            self._give(Clock, answer.data, answer.encoding, record.on_clock)

    def control(self, verb: Verb, message: Message, timeout: float = ANSWER_LIMIT) -> Result:
        """Ask the simulator for a verb and return its answer.

        Raises:
            ConnectionError: There was none in time.
            WireError: What came is no result.
        """
        answer = query(self._session, self._keys.ctl(verb), encode(message), timeout=timeout)[0]
        return decode(Result, answer.data, encoding_of(answer.encoding, answer.data), strict=False)

    def _ask(self, selector: str) -> list[Answer]:
        # A simulator that just died answers nobody; the record says what was seen until then.
        with suppress(ConnectionError):
            answers = query(self._session, selector, timeout=ANSWER_LIMIT)
            return [answer for answer in answers if answer.ok]
        return []

    @staticmethod
    def _give(kind: type[_M], data: bytes, encoding: str, take: Callable[[_M], None]) -> None:
        # In a world others may write too what cannot be read is nobody's, and a newer simulator may say more.
        with suppress(WireError):
            take(decode(kind, data, encoding_of(encoding, data), strict=False))


@contextmanager
def watching(link: Link, stop: threading.Event, *, listens: bool = True) -> Iterator[WorldWatch]:
    """Connect and watch until the `with` is left.

    Args:
        link: How.
        stop: Ends the try to connect.
        listens: Whether it hears what is published; else it only asks.

    Raises:
        ConnectionError: Nobody answers.
    """
    session = open_session(link, stop, timeout=OPEN_LIMIT)
    if session is None:
        raise ConnectionError(f"told to stop before {link.where()} answered")
    with session:
        watch = WorldWatch(session, link.world, listens=listens)
        try:
            yield watch
        finally:
            watch.close()
