"""The wire of rmw_zenoh: keys, liveliness tokens, qualities of service and attachments. Pure.

    key         <domain>/<topic>/<type>/<hash>
    token       @ros2_lv/<domain>/<session>/<node>/<entity>/<kind>/%/<namespace>/<name>[/<topic>/<type>/<hash>/<qos>]
    attachment  int64 sequence, int64 nanoseconds, byte 16, 16 bytes of the sender's id; little endian, 33 bytes

A `/` in a namespace or a topic of a token is written `%`. Tokens are how nodes see topics, services and each other.

Source:
    The tokens, keys and attachments of a node of ROS 2 Kilted with rmw_zenoh_cpp 0.6.7.
"""

from __future__ import annotations

import hashlib
import struct
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple, get_args

from intellwheels_schemas.errors import wrong_value

NO_HASH: Final = "TypeHashNotSupported"
"""What ROS 2 Humble, which has no type hashes, writes for a hash."""
LARGEST_DOMAIN: Final = 232
"""Largest domain of ROS 2."""
GID_BYTES: Final = 16
ATTACHMENT_BYTES: Final = 33

_ROOT: Final = "@ros2_lv"
_ATTACHMENT: Final = struct.Struct(f"<qqB{GID_BYTES}s")

EntityKind = Literal["MP", "MS", "SS", "SC"]
"""Publisher, subscription, service, client."""
_KINDS: Final = frozenset(get_args(EntityKind))


class Qos(NamedTuple):
    """A quality of service that keeps the last messages.

    Attributes:
        depth: Number of messages that are kept.
        reliable: False for best effort.
        transient_local: Whether a reader that comes late gets the last messages.
    """

    depth: int = 10
    reliable: bool = True
    transient_local: bool = False

    def text(self) -> str:
        """Return it as a token has it."""
        return f"{'' if self.reliable else '2'}:{'1' if self.transient_local else ''}:,{self.depth}:,:,:,,"


SENSOR_DATA: Final = Qos(depth=5, reliable=False)
LATCHED: Final = Qos(depth=1, transient_local=True)


class RosType(NamedTuple):
    """A type of ROS, such as `nav_msgs/msg/Odometry`.

    Attributes:
        name: Its name.
        hash: `RIHS01_` and 64 hex digits, or `NO_HASH`.
    """

    name: str
    hash: str

    @property
    def dds(self) -> str:
        """The name as keys have it: `nav_msgs::msg::dds_::Odometry_`."""
        package, kind, name = self.name.split("/")
        return f"{package}::{kind}::dds_::{name}_"


@dataclass(frozen=True, slots=True)
class NodeName:
    """A node in the graph.

    Attributes:
        domain: Domain of ROS 2.
        session: Zenoh's id of the session, hex digits.
        number: Number of the node in its session.
        namespace: `/` or `/chair1`.
        name: Name of the node.
    """

    domain: int
    session: str
    number: int
    namespace: str
    name: str

    def token(self) -> str:
        """Return the liveliness token of the node."""
        return self._token(self.number, "NN")

    def entity_token(self, number: int, kind: EntityKind, topic: str, of: RosType, qos: Qos) -> str:
        """Return the liveliness token of a publisher, a subscription, a service or a client.

        Args:
            number: Number of the entity in its session.
            kind: What it is.
            topic: Name of the topic or service, with its first slash.
            of: Its type.
            qos: Its quality of service.
        """
        return f"{self._token(number, kind)}/{_mangled(topic)}/{of.dds}/{of.hash}/{qos.text()}"

    def _token(self, number: int, kind: str) -> str:
        place = f"{_ROOT}/{self.domain}/{self.session}/{self.number}/{number}/{kind}"
        return f"{place}/%/{_mangled(self.namespace)}/{self.name}"


def topic_key(domain: int, topic: str, of: RosType) -> str:
    """Return the key of a topic or a service."""
    return f"{domain}/{topic.removeprefix('/')}/{of.dds}/{of.hash}"


def any_type_key(domain: int, topic: str) -> str:
    """Return the key expression of a topic with any type."""
    return f"{domain}/{topic.removeprefix('/')}/*/*"


def nodes_of(domain: int, namespace: str, name: str) -> str:
    """Return the key expression of the tokens of all nodes with a name."""
    return f"{_ROOT}/{domain}/*/*/*/NN/%/{_mangled(namespace)}/{name}"


def type_in(key: str) -> tuple[str, str]:
    """Return the type and the hash at the end of a key, as the key has them."""
    _, _, rest = key.rpartition("/")
    return key[: -len(rest) - 1].rpartition("/")[2], rest


def _mangled(name: str) -> str:
    return name.replace("/", "%")


# ---------------------------------------------------------------- attachments


class Attachment(NamedTuple):
    """What accompanies a message.

    Attributes:
        sequence: Number of the message, counted by its sender.
        time: Nanoseconds of the sender's clock, of Unix time.
        gid: Id of the sender.
    """

    sequence: int
    time: int
    gid: bytes

    def encoded(self) -> bytes:
        """Return the bytes."""
        return _ATTACHMENT.pack(self.sequence, self.time, GID_BYTES, self.gid)


def read_attachment(data: bytes | None) -> Attachment:
    """Return an attachment.

    Raises:
        WireError: It is missing, or has another form.
    """
    if data is None or len(data) != ATTACHMENT_BYTES:
        got = "none" if data is None else f"{len(data)} bytes"
        raise wrong_value("attachment", f"{ATTACHMENT_BYTES} bytes", got)
    sequence, time, length, gid = _ATTACHMENT.unpack(data)
    if length != GID_BYTES:
        raise wrong_value("attachment", f"an id of {GID_BYTES} bytes", f"{length}")
    return Attachment(sequence, time, gid)


def gid_of(token: str) -> bytes:
    """Return an id for an entity: 16 bytes that follow from its token, which no other entity has."""
    return hashlib.blake2b(token.encode(), digest_size=GID_BYTES).digest()


# ---------------------------------------------------------------- tokens of others


class EntityToken(NamedTuple):
    """What a liveliness token says.

    Attributes:
        namespace, node: The node.
        kind: `NN` for the node itself, or the kind of the entity.
        topic, dds, hash: Topic and type of an entity; empty for a node.
    """

    namespace: str
    node: str
    kind: str
    topic: str = ""
    dds: str = ""
    hash: str = ""


def read_token(key: str) -> EntityToken | None:
    """Return what a liveliness token says, or None if it is another key."""
    chunks = key.split("/")
    if len(chunks) not in (9, 13) or chunks[0] != _ROOT:
        return None
    kind, namespace, node = chunks[5], chunks[7].replace("%", "/"), chunks[8]
    if len(chunks) == 9:
        return EntityToken(namespace, node, kind) if kind == "NN" else None
    if kind not in _KINDS:
        return None
    return EntityToken(namespace, node, kind, chunks[9].replace("%", "/"), chunks[10], chunks[11])
