"""Turns what Zenoh delivered into the arrivals that the service takes."""

from __future__ import annotations

from functools import partial
from typing import Final, get_args

from intellwheels_schemas import zenoh_inbox
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.keys import Keys
from intellwheels_schemas.messages import Map, Record
from intellwheels_server.service.arrival import Arrival, Put, PutKind, Query, Token, Topic
from intellwheels_server.service.roster import presence_of

MAX_KEYS: Final = 4_096
"""Keys whose parts are remembered."""
MAX_SHOWN: Final = 200
"""Characters of an unknown key that are kept."""
TOPICS: Final[dict[str, Topic]] = {topic: topic for topic in get_args(Topic)}


class ArrivalReader:
    """Turns what Zenoh delivers into arrivals. What arrives on an unknown key is ignored.

    Args:
        keys: The keys of this world.
    """

    def __init__(self, keys: Keys) -> None:
        self._keys = keys
        # The same keys come again and again, so their parts are remembered, up to a limit: anyone can invent keys.
        self._known: dict[str, tuple[str, PutKind]] = {}
        self._map: Map | None = None
        self._map_bytes: dict[Encoding, bytes] = {}

    def read(self, arrival: zenoh_inbox.Arrival) -> Arrival | None:
        """Return what an arrival is, or None if it is to be ignored."""
        if isinstance(arrival, zenoh_inbox.Put):
            target = self._put_target(arrival.key)
            return Put(target[0], target[1], arrival.data, arrival.encoding) if target else self._stray(arrival.key)
        if isinstance(arrival, zenoh_inbox.Ask):
            return self._query(arrival)
        if isinstance(arrival, zenoh_inbox.Presence):
            token = self._keys.parse_token(arrival.key)
            if token is None:
                return None
            return Token(token.agent, token.role, presence_of(token.instance, token.crew), arrival.alive)
        target = self._put_target(arrival.key)
        return Put(target[0], target[1], b"", "", arrival.length) if target else self._stray(arrival.key)

    def _stray(self, key: str) -> Put | None:
        """Return a message on a key below `in` or `user` that nobody reads, without its bytes."""
        agent = self._keys.parse_stray(key)
        if agent is None:
            return None
        return Put(agent, "stray", b"", "", key=key[len(self._keys.prefix) :][:MAX_SHOWN])

    def _put_target(self, key: str) -> tuple[str, PutKind] | None:
        """Return the agent and the kind of message in a key."""
        try:
            return self._known[key]
        except KeyError:
            pass
        found: tuple[str, PutKind] | None = None
        if (put := self._keys.parse_in(key)) is not None:
            found = (put.agent, put.kind)
        elif (user := self._keys.parse_user(key)) is not None:
            found = (user, "user")
        elif (crew := self._keys.parse_crew(key)) is not None:
            found = (crew, "crew")
        if found is None:
            return None  # not remembered: an unknown key may be 64 kB long
        if len(self._known) >= MAX_KEYS:
            self._known.clear()
        self._known[key] = found
        return found

    def _query(self, arrival: zenoh_inbox.Ask) -> Query | None:
        keys = self._keys
        # A query with wildcards may ask for several keys. The queryable says which one of them this is about.
        served = arrival.served or arrival.key
        chunk = served.removeprefix(keys.prefix).partition("/")[0]
        topic = TOPICS.get(chunk) if served.startswith(keys.prefix) else None
        if chunk == "crew" and served.startswith(keys.prefix):
            topic = TOPICS.get(f"crew-{served.rpartition('/')[2]}")
        if topic is None:
            arrival.close()
            return None
        name = agent = ""
        if topic == "join":
            name = keys.parse_join(arrival.key) or ""
        elif topic == "leave":
            name = keys.parse_leave(arrival.key) or ""
        elif topic in ("crew-join", "crew-leave"):
            asked = keys.parse_crew_query(arrival.key)
            name = asked.crew if asked is not None else ""
        elif topic == "ctl" and (control := keys.parse_ctl(arrival.key)) is not None:
            name, agent = control
        return Query(
            topic=topic,
            name=name,
            data=arrival.data,
            encoding=arrival.encoding,
            send=partial(self._send, arrival, topic),
            close=arrival.close,
            parameters=_parameters(arrival.parameters),
            matches=partial(self._matches, arrival, topic),
            has_wildcards="*" in arrival.key,
            agent=agent,
        )

    def _matches(self, arrival: zenoh_inbox.Ask, topic: Topic, name: str) -> bool:
        return arrival.matches(f"{self._keys.prefix}{topic}/{name}")

    def _send(
        self, arrival: zenoh_inbox.Ask, topic: Topic, message: Record, encoding: Encoding, ok: bool, name: str | None
    ) -> None:
        data = self._map_data(message, encoding) if isinstance(message, Map) else encode(message, encoding)
        if ok:
            key = (arrival.served or None) if name is None else f"{self._keys.prefix}{topic}/{name}"
            # A reply needs a key without wildcards.
            arrival.reply(data, encoding, key if name is not None or "*" in arrival.key else None)
        else:
            arrival.refuse(data, encoding)

    def _map_data(self, floor: Map, encoding: Encoding) -> bytes:
        """Return a map as bytes. They may take longer than a tick to make, so those of the last map are kept."""
        if floor is not self._map:
            self._map, self._map_bytes = floor, {}
        if encoding not in self._map_bytes:
            self._map_bytes[encoding] = encode(floor, encoding)
        return self._map_bytes[encoding]


def _parameters(text: str) -> dict[str, str]:
    pairs = (pair.partition("=") for pair in text.split(";") if pair)
    return {name: value for name, _, value in pairs}
