"""Arrivals from the network, as plain data. The rest of the service does not see the network itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from intellwheels_schemas.codec import Encoding, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Record, Result, Role

PutKind = Literal["actions", "say", "pose", "user", "crew", "stray"]
"""What a message is. Those of a crew are its actions. A stray one is on a key that is none of an agent's."""

Topic = Literal["join", "leave", "crew-join", "crew-leave", "ctl", "map", "event", "body", "state", "clock"]


class Put(NamedTuple):
    """A message on a key that agents or users write.

    Attributes:
        agent: The agent or the crew in the key; empty for a stray message if that is no name.
        kind: Which of its keys.
        data: The payload; empty if it was too long to keep.
        encoding: Zenoh's encoding, as text.
        size: Bytes that arrived; more than `len(data)` if the payload was too long.
        key: For a stray message, the start of its key after the prefix of the world.
    """

    agent: str
    kind: PutKind
    data: bytes
    encoding: str
    size: int = 0
    key: str = ""


class Token(NamedTuple):
    """A liveliness token of one role of an agent appeared or disappeared.

    Attributes:
        agent: The agent.
        role: The role.
        presence: The instance, and the crew if there is one, as `roster.presence_of` returns it.
        present: Whether it appeared.
    """

    agent: str
    role: Role
    presence: str
    present: bool


@dataclass(slots=True, eq=False)
class Query:
    """A query that waits for its reply.

    Attributes:
        topic: The subject of the query.
        name: The agent, crew or verb in the key; empty if the key has none or an invalid one.
        agent: The agent that a control verb is about, if its key names one.
        data: The payload.
        encoding: Zenoh's encoding of the payload, as text. Replies use it too.
        send: Sends one reply: the message, its encoding, whether it is an ordinary reply or an error reply, and the
            last chunk of its key where that differs from the key of the query.
        close: Ends the query; no reply may be sent after it.
        parameters: What follows the `?` of the selector.
        matches: Returns whether the key expression matches a key with this last chunk.
        has_wildcards: Whether the key expression has wildcards.
    """

    topic: Topic
    name: str
    data: bytes
    encoding: str
    send: Callable[[Record, Encoding, bool, str | None], None]
    close: Callable[[], None]
    parameters: Mapping[str, str] = field(default_factory=dict)
    matches: Callable[[str], bool] = lambda _name: True
    has_wildcards: bool = False
    agent: str = ""

    def reply_encoding(self) -> Encoding:
        """Return the encoding of replies: XML if the query was XML, else JSON."""
        try:
            found = encoding_of(self.encoding, self.data)
        except WireError:
            return Encoding.JSON
        return Encoding.XML if found is Encoding.XML else Encoding.JSON

    def reply(self, message: Record) -> None:
        """Send the only reply and end the query. A `Result` that is not ok is an error reply, as every refusal is."""
        ok = not isinstance(message, Result) or message.code == "ok"
        self.send(message, self.reply_encoding(), ok, None)
        self.close()

    def refuse(self, message: Record) -> None:
        """Send an error reply and end the query."""
        self.send(message, self.reply_encoding(), False, None)
        self.close()

    def reply_each(self, messages: Mapping[str, Record]) -> None:
        """Send one reply for each entry, on a key that ends with its name, and end the query."""
        encoding = self.reply_encoding()
        for name, message in messages.items():
            self.send(message, encoding, True, name)
        self.close()


Arrival = Put | Token | Query
