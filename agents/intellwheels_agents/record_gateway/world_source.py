"""The messages of a world, from the network. Zenoh's threads fill an inbox, and one loop empties it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from typing import Any, Final, Protocol

from intellwheels_agents.record_gateway.crew_records import each_alone
from intellwheels_agents.record_gateway.translator import Entry, Translator
from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import decode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Map
from intellwheels_schemas.simulator_query import ask_simulator
from intellwheels_schemas.zenoh_inbox import Inbox, Presence, Put

ANSWER_TIMEOUT: Final = 2.0
"""Seconds to wait for what the simulator answers at once."""
TRY_EVERY: Final = 1.0
"""Seconds between two requests for the map or the bodies."""
SOON: Final = 2.0
"""Seconds without a simulator after which the log says so."""
WAIT: Final = 0.05
"""Longest wait for a message, s."""


class OtherRecording(Protocol):
    """A recording that takes the messages themselves."""

    def take(self, key: str, data: bytes, encoding: str) -> None:
        """Record a message."""
        ...

    def take_map(self, document: Map) -> None:
        """Record a map that was asked for."""
        ...


class WorldSource:
    """What a world publishes, and answers.

    Args:
        session: An open session.
        keys: The keys of the world.
        translator: What is recorded.
        write: Takes each entry.
        log: Takes lines for the log of the process.
        others: Other recordings, which take each message after the translator.
    """

    def __init__(
        self, session: Any, keys: Keys, translator: Translator, write: Callable[[Entry], None],
        log: Callable[[str], None], *, others: Sequence[OtherRecording] = (),
    ) -> None:  # fmt: skip
        self.inbox = Inbox()
        self._session = session
        self._keys = keys
        self._translator = translator
        self._write = write
        self._log = log
        self._others = others
        self._asked_at = -TRY_EVERY
        self._waits_since: float | None = time.monotonic()
        self._stack = ExitStack()

    def __enter__(self) -> WorldSource:
        """Subscribe to everything that is put."""
        keys, session = self._keys, self._session
        # Each kind by itself: the router of a lab lets nobody subscribe to more than the kinds that the contract names.
        of_agents = [
            f"{keys.prefix}{channel.key.replace('<agent>', '*')}"
            for channel in CHANNELS.values()
            if channel.kind == "put" and channel.key.startswith(("in/", "out/"))
        ]
        expressions = (
            keys.every_state, keys.every_body, keys.map, keys.event, keys.clock, *of_agents, keys.every_user,
            keys.every_crew_measures, f"{keys.prefix}crew/*/actions",
        )  # fmt: skip
        for expression in expressions:
            self._stack.enter_context(session.declare_subscriber(expression, self.inbox.on_sample))
        self._stack.enter_context(link.watch_tokens(session, keys.alive, self.inbox))
        return self

    def __exit__(self, *_: object) -> None:
        """Subscribe to nothing more."""
        self._stack.close()

    def work(self, stop: threading.Event, wait: float = WAIT) -> bool:
        """Record what has arrived; wait a moment if nothing has. Return whether something had arrived."""
        arrivals = self.inbox.take()
        if not arrivals:
            self.inbox.wait(wait)
            arrivals = self.inbox.take()
        for arrival in arrivals:
            if isinstance(arrival, Put):
                self._take(arrival.key, arrival.data, arrival.encoding)
            elif isinstance(arrival, Presence) and arrival.alive:
                self._waits_since = None
                self._translator.wants_map = self._translator.wants_bodies = True
                self._asked_at = -TRY_EVERY
        if self._waits_since is not None and time.monotonic() > self._waits_since + SOON:
            self._waits_since = None
            self._log(f"waiting why='no simulator at {self._keys.alive} yet'")
        if (self._translator.wants_map or self._translator.wants_bodies) and not stop.is_set():
            self._ask(stop)
        return bool(arrivals)

    def _ask(self, stop: threading.Event) -> None:
        """Ask for the bodies and the map, at most once a second."""
        now = time.monotonic()
        if now < self._asked_at + TRY_EVERY:
            return
        self._asked_at = now
        keys, wants_map = self._keys, self._translator.wants_map
        if self._translator.wants_bodies:
            self._translator.wants_bodies = False
            for key in (keys.clock, keys.every_body, keys.every_state):
                for answer in self._answers(key, stop):
                    self._take(answer.key, answer.data, answer.encoding)
        if wants_map:
            for answer in self._answers(keys.map, stop):
                try:
                    document = decode(Map, answer.data, encoding_of(answer.encoding, answer.data), strict=False)
                except WireError as error:
                    self._log(f"dropped key={keys.map} why={error.text!r}")
                else:
                    self._record(self._translator.take_map(document))
                    for other in self._others:
                        other.take_map(document)
                    break

    def _answers(self, key: str, stop: threading.Event) -> Iterator[link.Answer]:
        try:
            answers = ask_simulator(self._session, self._keys, key, timeout=ANSWER_TIMEOUT, stop=stop)
        except ConnectionError:
            return
        yield from (answer for answer in answers if answer.ok)

    def _take(self, key: str, data: bytes, encoding: str) -> None:
        for own, alone in each_alone(self._keys, key, data, encoding):
            self._record(self._translator.take(own, alone, encoding))
            for other in self._others:
                other.take(own, alone, encoding)

    def _record(self, entries: list[Entry]) -> None:
        for entry in entries:
            self._write(entry)
