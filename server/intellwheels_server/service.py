"""The simulator on the network. The only file of the server that knows zenoh, and that through `link`.

Zenoh calls back on its own threads; every callback does one thing, put what arrived into the inbox. The loop alone
touches the world, and every wait of it ends.
"""

from __future__ import annotations

import contextlib
from functools import partial

import zenoh

from intellwheels_schemas import link
from intellwheels_schemas.channels import CHANNELS
from intellwheels_schemas.codec import Encoding, encode
from intellwheels_schemas.keys import Keys, OutKind
from intellwheels_schemas.messages import Body, Clock, Event, MapInfo, Record, WorldState
from intellwheels_server.arrival import Arrival, Ask, Put, Token, Topic

SHUTDOWN: Final = 0.3
"""Seconds for what was put last to leave before the session closes."""
PRESENCE_TIMEOUT: Final = 1.0
"""Seconds in which another simulator of this world would say so."""


class WorldTakenError(RuntimeError):
    """There is a simulator in this world; the text says so."""


class Network:
    """The outlet: publishers declared once, a put never waits.

    Args:
        session: Where.
        keys: Of this world.
    """

    def __init__(self, session: zenoh.Session, keys: Keys) -> None:
        self._session = session
        self._keys = keys
        self._agents: dict[str, dict[str, tuple[zenoh.Publisher, Encoding]]] = {}
        self._parts: dict[int, zenoh.Publisher] = {}
        self._bodies: dict[str, zenoh.Publisher] = {}
        self._event = link.declare(session, keys.event, CHANNELS["event"])
        self._clock = link.declare(session, keys.clock, CHANNELS["clock"])
        self._map = link.declare(session, keys.map, CHANNELS["map"])

    def agent(self, agent: str, kind: OutKind, message: Record, encoding: Encoding) -> None:
        """Put `out/<agent>/<kind>`."""
        publishers = self._agents.get(agent)
        if publishers is not None:
            publisher, declared = publishers[kind]
            if declared is encoding:
                publisher.put(encode(message, encoding))
                return
        with link.declare(self._session, self._keys.out(agent, kind), CHANNELS[kind], encoding) as once:
            once.put(encode(message, encoding))

    def welcome(self, agent: str, mind: Encoding, body: Encoding) -> None:
        """Declare what is put to this agent, unless it is declared so already."""
        wanted: dict[OutKind, Encoding] = {"measures": mind, "power": body, "error": mind}
        publishers = self._agents.setdefault(agent, {})
        for kind, encoding in wanted.items():
            if kind not in publishers or publishers[kind][1] is not encoding:
                if kind in publishers:
                    publishers[kind][0].undeclare()
                key = self._keys.out(agent, kind)
                publishers[kind] = (link.declare(self._session, key, CHANNELS[kind], encoding), encoding)

    def farewell(self, agent: str) -> None:
        """Undeclare what was put to this agent."""
        for publisher, _ in self._agents.pop(agent, {}).values():
            publisher.undeclare()
        if agent in self._bodies:
            self._bodies.pop(agent).undeclare()

    def body(self, agent: str, body: Body) -> None:
        """Put `body/<agent>`."""
        if agent not in self._bodies:
            self._bodies[agent] = link.declare(self._session, self._keys.body(agent), CHANNELS["body"])
        self._bodies[agent].put(encode(body))

    def state(self, state: WorldState) -> None:
        """Put `state/<part>`."""
        publisher = self._parts.get(state.part)
        if publisher is None:
            publisher = link.declare(self._session, self._keys.state(state.part), CHANNELS["state"])
            self._parts[state.part] = publisher
        publisher.put(encode(state))

    def event(self, event: Event) -> None:
        """Put `event`."""
        self._event.put(encode(event))

    def clock(self, clock: Clock) -> None:
        """Put `clock`."""
        self._clock.put(encode(clock))

    def map(self, info: MapInfo) -> None:
        """Put `map`."""
        self._map.put(encode(info))

    def tell(self, line: str) -> None:
        """Write a line that scripts wait for."""
        tell(line)

    def note(self, line: str) -> None:
        """Write a line for people."""
        note(line)


class Post:
    """Turns what zenoh brought into arrivals. Unknown keys are nobody's and become nothing.

    Args:
        keys: Of this world.
    """

    def __init__(self, keys: Keys) -> None:
        self._keys = keys
        # Whoever writes a key writes it again: its parts are looked up. Bounded, for keys are strangers' words.
        self._known: dict[str, tuple[str, PutKind] | None] = {}

    def open(self, arrival: link.Arrival) -> Arrival | None:
        """Return what an arrival is, or None when it is nothing to us."""
        if isinstance(arrival, link.Put):
            writer = self._writer(arrival.key)
            return Put(writer[0], writer[1], arrival.data, arrival.encoding) if writer else None
        if isinstance(arrival, link.Ask):
            return self._ask(arrival)
        if isinstance(arrival, link.Presence):
            token = self._keys.parse_token(arrival.key)
            return Token(token.agent, token.role, token.instance, arrival.alive) if token else None
        writer = self._writer(arrival.key)
        return Put(writer[0], writer[1], b"", "", arrival.length) if writer else None

    def _writer(self, key: str) -> tuple[str, PutKind] | None:
        try:
            return self._known[key]
        except KeyError:
            pass
        found: tuple[str, PutKind] | None = None
        if (put := self._keys.parse_in(key)) is not None:
            found = (put.agent, put.kind)
        elif (user := self._keys.parse_user(key)) is not None:
            found = (user, "user")
        if len(self._known) >= _KEYS_KNOWN:
            self._known.clear()
        self._known[key] = found
        return found

    def _ask(self, arrival: link.Ask) -> Ask:
        topic, name = self._asked(arrival.key)
        return Ask(
            topic=topic,
            name=name,
            data=arrival.data,
            encoding=arrival.encoding,
            send=partial(self._send, arrival, topic),
            close=arrival.close,
            parameters=_parameters(arrival.parameters),
            matches=partial(_matches, self._keys, zenoh.KeyExpr(arrival.key), topic),
            wild="*" in arrival.key,
        )

    def _asked(self, key: str) -> tuple[Topic, str]:
        chunk = key[len(self._keys.prefix) :].partition("/")[0] if key.startswith(self._keys.prefix) else ""
        if chunk == "join":
            return "join", self._keys.parse_join(key) or ""
        if chunk == "leave":
            return "leave", self._keys.parse_leave(key) or ""
        return "ctl", self._keys.parse_ctl(key) or ""

    def _send(self, arrival: link.Ask, topic: Topic, message: Record, encoding: Encoding, ok: bool, name: str | None) -> None:
        data = encode(message, encoding)
        with contextlib.suppress(zenoh.ZError):  # who asked may be gone
            if ok:
                arrival.reply(data, encoding, self._reply_key(topic, name) if name is not None else None)
            else:
                arrival.refuse(data, encoding)
