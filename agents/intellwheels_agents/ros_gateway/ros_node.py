"""Nodes of ROS 2 on the network, as rmw_zenoh makes them. The only file of the gateway that knows zenoh.

Zenoh calls back on its own threads. A callback only stores what arrived. Velocities and goals wait in a bounded inbox
until their reader takes them; each request of a service is answered on one of a few threads. Bytes that cannot be read
are dropped with a line in the log.
"""

from __future__ import annotations

import itertools
import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import partial
from typing import Any, Final, NamedTuple, Self

import zenoh
import zenoh.ext

from intellwheels_agents.ros_gateway.chair_messages import Topic
from intellwheels_agents.ros_gateway.rmw_wire import (
    NO_HASH,
    Attachment,
    EntityKind,
    NodeName,
    Qos,
    RosType,
    any_type_key,
    gid_of,
    nodes_of,
    read_attachment,
    topic_key,
    type_in,
)
from intellwheels_agents.ros_gateway.ros_types import decode_message, encode_message, ros_type
from intellwheels_schemas import link
from intellwheels_schemas.errors import WireError, wrong_value
from intellwheels_schemas.session_closing import close_session

ROOM: Final = 256
"""Messages that may wait for a reader."""
LONGEST_MESSAGE: Final = 4096
"""Bytes of a velocity or a goal."""
LONGEST_REQUEST: Final = 1 << 17
"""Bytes of a request of a service: a robot as text has up to 64 KiB."""
LONGEST_MAP: Final = 1 << 20
"""Bytes of a request that may have a map as text."""
_WITH_MAP: Final = "/LoadWorld"
WORKERS: Final = 8
"""Requests that are answered at the same time: a request to make steps may take minutes."""
WAITING: Final = 32
"""Requests that may wait in all. Others get no answer."""
HEARTBEAT: Final = 0.5
"""Seconds after which a reader of a latched topic notices that it missed the last message."""
FIND_TIMEOUT: Final = 1.0
"""Seconds in which the tokens of other nodes are reported."""

Answer = Callable[[Any], Any]
"""Answers a request message with a response message."""


class DropLog:
    """Tells what was dropped: of each kind the 1st, 10th, 100th and so on."""

    def __init__(self, log: Callable[[str], None]) -> None:
        self._log = log
        self._counts: dict[str, int] = {}
        self._lock = threading.Lock()

    def dropped(self, what: str, why: str) -> None:
        """Tell that something was dropped, and why."""
        with self._lock:
            count = self._counts[what] = self._counts.get(what, 0) + 1
        if str(count).strip("0") == "1":
            self._log(f"dropped {what} count={count} why={why!r}")


class _Raw(NamedTuple):
    key: str
    data: bytes
    attachment: bytes | None


class TopicInbox:
    """What arrives on a topic, with the types that are read. One thread reads it."""

    def __init__(self, topic: str, types: Sequence[RosType], drops: DropLog) -> None:
        self._topic = topic
        self._types = {of.dds: of for of in types}
        self._drops = drops
        self._kept: deque[_Raw] = deque(maxlen=ROOM)
        self._some = threading.Condition()

    def on_sample(self, sample: zenoh.Sample) -> None:
        """Keep a sample. This is the callback of the subscriber."""
        length = len(sample.payload)
        attachment = sample.attachment
        kept = _Raw(
            str(sample.key_expr),
            sample.payload.to_bytes() if length <= LONGEST_MESSAGE else bytes(LONGEST_MESSAGE + 1),
            attachment.to_bytes() if attachment is not None and len(attachment) <= LONGEST_MESSAGE else None,
        )
        with self._some:
            self._kept.append(kept)
            self._some.notify()

    def wait(self, seconds: float) -> bool:
        """Wait for a message or the time-out; return whether there is a message."""
        with self._some:
            return bool(self._kept) or self._some.wait(max(seconds, 0.0))

    def take(self) -> list[tuple[str, Any]]:
        """Remove and return all messages that can be read, oldest first: the name of the type, and the message."""
        with self._some:
            raw = list(self._kept)
            self._kept.clear()
        found = []
        for one in raw:
            try:
                found.append(self._read(one))
            except WireError as error:
                self._drops.dropped(f"topic={self._topic}", error.text)
        return found

    def refuse(self, error: WireError) -> None:
        """Tell that a message was read but is not obeyed."""
        self._drops.dropped(f"topic={self._topic}", error.text)

    def _read(self, raw: _Raw) -> tuple[str, Any]:
        dds, type_hash = type_in(raw.key)
        of = self._types.get(dds)
        if of is None or type_hash not in (of.hash, NO_HASH):
            expected = " or ".join(f"{one.dds}/{one.hash}" for one in self._types.values())
            raise wrong_value(self._topic, f"the type {expected}", f"{dds[:80]}/{type_hash[:80]}")
        if len(raw.data) > LONGEST_MESSAGE:
            raise wrong_value(self._topic, f"at most {LONGEST_MESSAGE} bytes", "more")
        read_attachment(raw.attachment)
        return of.name, decode_message(of.name, raw.data)


class RosPublisher:
    """A publisher of a topic."""

    def __init__(self, publisher: zenoh.Publisher | zenoh.ext.AdvancedPublisher, gid: bytes) -> None:
        self._publisher = publisher
        self._gid = gid
        self._sequence = itertools.count(1)

    def publish(self, message: Any) -> None:
        """Send a message. It never waits for a reader."""
        attachment = Attachment(next(self._sequence), time.time_ns(), self._gid)
        self._publisher.put(encode_message(message), attachment=attachment.encoded())


class RosSession:
    """A session in the graph of a domain, with its nodes. Use it in a `with` statement."""

    def __init__(self, session: zenoh.Session, domain: int, *, humble: bool, log: Callable[[str], None]) -> None:
        """Take an open session.

        Args:
            session: The session, which this object closes.
            domain: Domain of ROS 2.
            humble: Whether types have no hashes, as in ROS 2 Humble.
            log: Takes lines for the log.
        """
        self._session = session
        self._domain = domain
        self._humble = humble
        self._numbers = itertools.count()
        self._stack = ExitStack()
        self._work: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._workers: list[threading.Thread] = []
        self.drops = DropLog(log)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for _worker in self._workers:
            self._work.put(None)
        # In reverse order: a node goes after its entities. A declaration that is still open makes Python hang.
        self._stack.close()
        close_session(self._session)

    def has_node(self, namespace: str, name: str) -> bool:
        """Return whether another session has a node of that name."""
        return bool(link.tokens(self._session, nodes_of(self._domain, namespace, name), timeout=FIND_TIMEOUT))

    def node(self, namespace: str, name: str) -> RosNode:
        """Declare a node."""
        number = next(self._numbers)
        found = NodeName(self._domain, str(self._session.info.zid()), number, namespace, name)
        self._stack.enter_context(self._session.liveliness().declare_token(found.token()))
        return RosNode(self, found)

    def type_of(self, name: str) -> RosType:
        """Return a type as this graph has it."""
        return ros_type(name)._replace(hash=NO_HASH) if self._humble else ros_type(name)

    def declare(self, node: NodeName, kind: EntityKind, topic: str, of: RosType, qos: Qos) -> bytes:
        """Declare the token of an entity, and return its id."""
        token = node.entity_token(next(self._numbers), kind, topic, of, qos)
        self._stack.enter_context(self._session.liveliness().declare_token(token))
        return gid_of(token)

    def publisher(self, key: str, qos: Qos, gid: bytes) -> RosPublisher:
        """Declare a publisher. One of a latched topic keeps the last messages for late readers."""
        if not qos.transient_local:
            plain = self._session.declare_publisher(key, congestion_control=zenoh.CongestionControl.DROP)
            return RosPublisher(self._stack.enter_context(plain), gid)
        latched = zenoh.ext.declare_advanced_publisher(
            self._session, key, congestion_control=zenoh.CongestionControl.DROP,
            cache=zenoh.ext.CacheConfig(qos.depth),
            sample_miss_detection=zenoh.ext.MissDetectionConfig(heartbeat=None, sporadic_heartbeat=HEARTBEAT),
            publisher_detection=True,
        )  # fmt: skip
        return RosPublisher(self._stack.enter_context(latched), gid)

    def subscribe(self, topic: str, inbox: TopicInbox) -> None:
        """Put what arrives on a topic, with whatever type, into an inbox."""
        key = any_type_key(self._domain, topic)
        self._stack.enter_context(self._session.declare_subscriber(key, inbox.on_sample))

    def serve(self, key: str, service: str, kind: str, answer: Answer) -> None:
        """Answer the requests on a key."""
        waiting = threading.Semaphore(WAITING)
        self._start_workers()

        def work(query: zenoh.Query) -> None:
            try:
                with query:
                    self._answer(query, key, kind, answer)
            except WireError as error:
                self.drops.dropped(f"service={service}", error.text)
            except Exception as error:
                # A fault in one answer must not end the thread that answers the others.
                self.drops.dropped(f"service={service}", f"{type(error).__name__}: {error}")
            finally:
                waiting.release()

        def on_query(query: zenoh.Query) -> None:
            if waiting.acquire(blocking=False):
                self._work.put(partial(work, query))
            else:
                self.drops.dropped(f"service={service}", f"{WAITING} requests wait already")

        self._stack.enter_context(self._session.declare_queryable(key, on_query, complete=True))

    def _start_workers(self) -> None:
        while len(self._workers) < WORKERS:
            # Daemons: a request that makes many steps must not delay the end of the process.
            worker = threading.Thread(target=self._run_worker, name="service", daemon=True)
            self._workers.append(worker)
            worker.start()

    def _run_worker(self) -> None:
        while (work := self._work.get()) is not None:
            work()

    def _answer(self, query: zenoh.Query, key: str, kind: str, answer: Answer) -> None:
        payload, attached = query.payload, query.attachment
        longest = LONGEST_MAP if kind.endswith(_WITH_MAP) else LONGEST_REQUEST
        if payload is None or len(payload) > longest:
            got = "none" if payload is None else f"{len(payload)} bytes"
            raise wrong_value("request", f"at most {longest} bytes", got)
        request = read_attachment(None if attached is None else attached.to_bytes())
        response = answer(decode_message(f"{kind}_Request", payload.to_bytes()))
        reply = request._replace(time=time.time_ns())
        with suppress(zenoh.ZError):  # whoever asked may be gone
            query.reply(key, encode_message(response), attachment=reply.encoded())

    def key_of(self, topic: str, of: RosType) -> str:
        """Return the key of a topic or a service."""
        return topic_key(self._domain, topic, of)


class RosNode:
    """A node with publishers, subscriptions and services."""

    def __init__(self, session: RosSession, name: NodeName) -> None:
        self._session = session
        self._name = name
        self._publishers: dict[str, RosPublisher] = {}

    def advertise(self, topics: Sequence[Topic]) -> None:
        """Declare publishers of topics; one that is declared already stays."""
        for topic in topics:
            if topic.name not in self._publishers:
                of = self._session.type_of(topic.type)
                gid = self._session.declare(self._name, "MP", topic.name, of, topic.qos)
                key = self._session.key_of(topic.name, of)
                self._publishers[topic.name] = self._session.publisher(key, topic.qos, gid)

    def publish(self, topic: str, message: Any) -> None:
        """Send a message on a topic that was advertised."""
        self._publishers[topic].publish(message)

    def subscribe(self, topic: str, types: Sequence[str]) -> TopicInbox:
        """Return the inbox of a topic whose messages have one of some types."""
        found = [self._session.type_of(name) for name in types]
        for of in found:
            self._session.declare(self._name, "MS", topic, of, Qos())
        inbox = TopicInbox(topic, found, self._session.drops)
        self._session.subscribe(topic, inbox)
        return inbox

    def serve(self, services: Mapping[str, tuple[str, Answer]]) -> None:
        """Serve services, by name: the type, and what answers a request."""
        for service, (kind, answer) in services.items():
            of = self._session.type_of(kind)
            self._session.declare(self._name, "SS", service, of, Qos())
            self._session.serve(self._session.key_of(service, of), service, kind, answer)
