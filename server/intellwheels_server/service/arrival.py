"""What arrives from the network, as plain data: all that the live run knows of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from intellwheels_schemas.codec import Encoding, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import Record, Role

PutKind = Literal["actions", "say", "pose", "user"]
Topic = Literal["join", "leave", "ctl", "map", "event", "body", "state", "clock"]


class Put(NamedTuple):
    """A message on a key that agents or users write.

    Attributes:
        agent: Whose key it is.
        kind: Which of its keys.
        data: The payload.
        encoding: Zenoh's encoding, as text.
        size: Bytes that came; more than `len(data)` when the payload was too long to keep.
    """

    agent: str
    kind: PutKind
    data: bytes
    encoding: str
    size: int = 0


class Token(NamedTuple):
    """The presence of an agent's role began or ended."""

    agent: str
    role: Role
    instance: str
    present: bool


@dataclass(slots=True, eq=False)
class Ask:
    """A query that waits for its reply.

    Attributes:
        topic: What is asked for.
        name: Agent or verb; empty where there is none, or none that could be.
        data: The payload.
        encoding: Zenoh's encoding, as text; says also how to answer.
        send: Sends one reply: the message, its encoding, whether it is an ordinary reply or an error reply, and the
            last chunk of its key where that is not the query's.
        close: Ends the query; no reply may be sent after it.
        parameters: What stands behind the `?`.
        matches: Whether a last chunk of the key is asked for.
        wild: Whether the key has wildcards.
    """

    topic: Topic
    name: str
    data: bytes
    encoding: str
    send: Callable[[Record, Encoding, bool, str | None], None]
    close: Callable[[], None]
    parameters: Mapping[str, str] = field(default_factory=dict)
    matches: Callable[[str], bool] = lambda _name: True
    wild: bool = False

    def reply_encoding(self) -> Encoding:
        """Return how to answer: as asked, else as the question was written, else JSON."""
        try:
            found = encoding_of(self.encoding, self.data)
        except WireError:
            return Encoding.JSON
        return Encoding.XML if found is Encoding.XML else Encoding.JSON

    def reply(self, message: Record) -> None:
        """Send the only reply and end the query."""
        self.send(message, self.reply_encoding(), True, None)
        self.close()

    def refuse(self, message: Record) -> None:
        """Send an error reply and end the query."""
        self.send(message, self.reply_encoding(), False, None)
        self.close()

    def replies(self, messages: Mapping[str, Record]) -> None:
        """Send replies on keys that end with these names and end the query."""
        encoding = self.reply_encoding()
        for name, message in messages.items():
            self.send(message, encoding, True, name)
        self.close()


Arrival = Put | Token | Ask
