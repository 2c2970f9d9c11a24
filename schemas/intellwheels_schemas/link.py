"""The link to the others. The only file of the contract that knows zenoh.

Zenoh calls back on threads of its own; every callback does one thing, put what arrived in an
`Inbox`. Every wait has a deadline and looks at the stop event. A put never fails and never waits.
"""

from __future__ import annotations

import argparse
import json
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

import zenoh

from intellwheels_schemas import defaults
from intellwheels_schemas.channels import Channel
from intellwheels_schemas.codec import MAX_BYTES, Encoding
from intellwheels_schemas.names import check_name

DEFAULT_WORLD: Final = defaults.WORLD
DEFAULT_ENDPOINT: Final = "tcp/127.0.0.1:7447"
QUEUE_ROOM: Final = 16
"""Batches a transport holds per priority. With 2, Zenoh's default, lockstep of 20 agents loses measures."""

TRY_EVERY: Final = 1.0
"""Seconds between two tries to open a session."""

_SLICE: Final = 0.2  # seconds of a wait, so that signals are seen
_ASKINGS: Final = 3
_PAUSE: Final = 0.02

_PRIORITIES: Final[dict[str, zenoh.Priority]] = {
    "real-time": zenoh.Priority.REAL_TIME,
    "interactive-high": zenoh.Priority.INTERACTIVE_HIGH,
    "data-high": zenoh.Priority.DATA_HIGH,
    "data": zenoh.Priority.DATA,
    "data-low": zenoh.Priority.DATA_LOW,
}

# What holds in every session, whoever configures the rest.
_SETTINGS: Final[dict[str, Any]] = {
    "scouting/multicast/enabled": False,
    # Peers that gossip walk around a router's access control.
    "scouting/gossip/enabled": False,
    "transport/shared_memory/enabled": False,
    "transport/link/rx/max_message_size": MAX_BYTES,
    "transport/link/tx/queue/size": {
        "control": QUEUE_ROOM, "real_time": QUEUE_ROOM, "interactive_high": QUEUE_ROOM,
        "interactive_low": QUEUE_ROOM, "data_high": QUEUE_ROOM, "data": QUEUE_ROOM, "data_low": QUEUE_ROOM,
        "background": QUEUE_ROOM,
    },
    # An address that swallows packets must not hold a process that was told to stop.
    "transport/unicast/open_timeout": 3000,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Link:
    """How a process reaches the others.

    Attributes:
        world: The simulation it takes part in.
        listen: Endpoints to be found at; not empty makes it a peer.
        connect: Endpoints of a router or of a simulator that listens.
        config: A Zenoh configuration file for the rest, or None.
    """

    world: str = DEFAULT_WORLD
    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    config: Path | None = None

    def where(self) -> str:
        """Return where this link leads, for people."""
        return ", ".join(self.listen + self.connect) or str(self.config or DEFAULT_ENDPOINT)


def add_link_options(parser: argparse.ArgumentParser, *, listens: bool = False) -> None:
    """Give `parser` the options every command shares.

    Args:
        parser: Of a command.
        listens: Whether the command listens where nothing is said (the simulator), or connects.
    """
    group = parser.add_argument_group("link")
    if listens:
        said, unsaid = f" (default: {DEFAULT_ENDPOINT}, unless --connect or --config is given)", ""
    else:
        said, unsaid = "", f" (default: {DEFAULT_ENDPOINT}, unless --listen or --config is given)"
    group.add_argument(
        "--world", default=DEFAULT_WORLD, metavar="NAME", help="which simulation, of all on this link (default: main)"
    )
    group.add_argument(
        "--connect", action="append", default=[], metavar="ENDPOINT",
        help=f"a router, or a simulator that listens, such as tcp/10.0.0.5:7447; may be repeated{unsaid}",
    )  # fmt: skip
    group.add_argument(
        "--listen", action="append", default=[], metavar="ENDPOINT",
        help=f"be reachable there without a router; may be repeated{said}",
    )  # fmt: skip
    group.add_argument("--config", type=Path, metavar="FILE", help="a Zenoh configuration (JSON5) for all the rest")
    group.set_defaults(link_listens=listens)


def link_of(options: argparse.Namespace) -> Link:
    """Return the link that parsed options ask for.

    Raises:
        WireError: `value`, when the world's name is none.
    """
    listen, connect = tuple(options.listen), tuple(options.connect)
    if not listen and not connect and options.config is None:
        if options.link_listens:
            listen = (DEFAULT_ENDPOINT,)
        else:
            connect = (DEFAULT_ENDPOINT,)
    return Link(check_name(options.world, "--world"), listen, connect, options.config)


def config_of(link: Link) -> zenoh.Config:
    """Return the Zenoh configuration of a link.

    Raises:
        ConnectionError: The file is not there or is no configuration, or an endpoint is none.
    """
    try:
        config = zenoh.Config() if link.config is None else zenoh.Config.from_file(link.config)
        settings = dict(_SETTINGS)
        if link.listen or link.connect or link.config is None:
            settings["mode"] = "peer" if link.listen else "client"
            settings["listen/endpoints"] = list(link.listen)
            settings["connect/endpoints"] = list(link.connect or (() if link.listen else (DEFAULT_ENDPOINT,)))
        if link.listen:
            # Without these a taken port is only logged.
            settings["listen/exit_on_failure"] = True
            settings["listen/timeout_ms"] = 0
        for key, value in settings.items():
            config.insert_json5(key, json.dumps(value))
    except (zenoh.ZError, OSError, ValueError) as error:
        raise ConnectionError(f"link: expected a Zenoh configuration and endpoints, got {error}") from None
    return config


def open_session(
    link: Link,
    stop: threading.Event,
    *,
    timeout: float | None = None,
    waiting: Callable[[str], None] | None = None,
) -> zenoh.Session | None:
    """Return a session, or None when `stop` was set before there was one. Close it in a `with`.

    Tries once a second while nobody answers; a port that is taken fails at once.

    Args:
        link: How.
        stop: Looked at between tries.
        timeout: Seconds after which to give up; None for never.
        waiting: Called once with words when the first try fails.

    Raises:
        ConnectionError: In words: the port is taken, nobody answered in time, the options make no sense.
    """
    deadline = None if timeout is None else time.monotonic() + timeout
    zenoh.init_log_from_env_or("off")
    config = config_of(link)
    while not stop.is_set():
        began = time.monotonic()
        try:
            return zenoh.open(config)
        except zenoh.ZError as error:
            if link.listen and "in use" in str(error):
                taken = ", ".join(link.listen)
                raise ConnectionError(
                    f"cannot listen at {taken}: it is taken, perhaps by another simulator; "
                    "give another with --listen, or join it with --connect"
                ) from None
            if link.listen:
                raise ConnectionError(f"cannot listen at {', '.join(link.listen)}: {_reason(error)}") from None
            words = f"nobody answers at {link.where()}"
        if waiting is not None:
            waiting(words)
            waiting = None
        if deadline is not None and time.monotonic() >= deadline:
            raise ConnectionError(words)
        while not stop.is_set() and (left := _until(began + TRY_EVERY, deadline)) > 0:
            stop.wait(min(left, _SLICE))
    return None


def router_settings(listen: Sequence[str]) -> str:
    """Return the configuration of a router for this contract, as JSON: `iw-router` and `zenohd -c` take it alike.

    Args:
        listen: Endpoints, such as `tcp/0.0.0.0:7447`.
    """
    nested: dict[str, Any] = {}
    settings = {**_SETTINGS, "mode": "router", "listen/endpoints": list(listen), "scouting/gossip/enabled": False}
    for key, value in settings.items():
        *path, last = key.split("/")
        place = nested
        for part in path:
            place = place.setdefault(part, {})
        place[last] = value
    return json.dumps(nested, indent=2) + "\n"


def open_router(listen: Sequence[str]) -> zenoh.Session:
    """Return a session that is a router: whoever connects to it meets all others that do. Close it in a `with`.

    Raises:
        ConnectionError: In words: an endpoint is none, or its port is taken.
    """
    zenoh.init_log_from_env_or("off")
    try:
        config = zenoh.Config.from_json5(router_settings(listen))
        config.insert_json5("listen/exit_on_failure", "true")
        config.insert_json5("listen/timeout_ms", "0")
        return zenoh.open(config)
    except (zenoh.ZError, ValueError) as error:
        why = "it is taken" if "in use" in str(error) else _reason(error)
        raise ConnectionError(f"cannot listen at {', '.join(listen)}: {why}") from None


def _until(moment: float, deadline: float | None) -> float:
    return min(moment, moment if deadline is None else deadline) - time.monotonic()


def _reason(error: Exception) -> str:
    # Zenoh's texts end in the place in its own source.
    return str(error).partition(" at ")[0][:200]


# ---------------------------------------------------------------- out


def declare(session: zenoh.Session, key: str, channel: Channel, encoding: Encoding = Encoding.JSON) -> zenoh.Publisher:
    """Return a publisher of a key, sent as its channel says. Without one a put costs 65 µs through a router."""
    return session.declare_publisher(
        key,
        encoding=zenoh.Encoding(encoding.value),
        congestion_control=zenoh.CongestionControl.DROP,
        priority=_PRIORITIES[channel.priority],
        express=channel.express,
    )


class Answer(NamedTuple):
    """A reply to a query.

    Attributes:
        key: The key it is on; empty for an error reply.
        data: The payload.
        encoding: Its encoding, as text.
        ok: Whether it is a reply, not an error reply.
    """

    key: str
    data: bytes
    encoding: str
    ok: bool


def query(
    session: zenoh.Session,
    selector: str,
    data: bytes | None = None,
    encoding: Encoding = Encoding.JSON,
    *,
    timeout: float = 5.0,
    stop: threading.Event | None = None,
) -> list[Answer]:
    """Ask, and return all replies, at least one.

    Args:
        session: Where.
        selector: Key, perhaps with wildcards and parameters (`event?since=7`).
        data: What is asked with, or None.
        encoding: Of `data`, and the one wanted for the reply.
        timeout: Seconds to wait.
        stop: Ends the wait.

    Raises:
        ConnectionError: Nobody replied: no simulator, or not allowed; Zenoh tells no difference.
    """
    answers: deque[Answer] = deque()
    done = threading.Event()

    def on_reply(reply: zenoh.Reply) -> None:
        if (sample := reply.ok) is not None:
            answers.append(Answer(str(sample.key_expr), sample.payload.to_bytes(), str(sample.encoding), True))
        elif (error := reply.err) is not None and str(error.encoding) in {member.value for member in Encoding}:
            answers.append(Answer("", error.payload.to_bytes(), str(error.encoding), False))

    session.get(
        selector,
        zenoh.handlers.Callback(on_reply, done.set),
        # A body's parts are several replies of one writer, and none may stand for another.
        consolidation=zenoh.ConsolidationMode.NONE,
        target=zenoh.QueryTarget.ALL,
        timeout=timeout,
        payload=data if data is not None else b"",
        encoding=zenoh.Encoding(encoding.value),
    )
    # Zenoh's own time-out ends the query; the half second more is for its doing so.
    deadline = time.monotonic() + timeout + 0.5
    while not done.wait(_SLICE) and time.monotonic() < deadline and (stop is None or not stop.is_set()):
        pass
    if not answers:
        raise ConnectionError(f"no simulator at {selector.partition('?')[0]}, or not allowed")
    return list(answers)


# ---------------------------------------------------------------- in


class Put(NamedTuple):
    """A sample that arrived."""

    key: str
    data: bytes
    encoding: str


class TooLong(NamedTuple):
    """A sample or query that was longer than the inbox takes; its bytes were not kept."""

    key: str
    length: int


class Ask(NamedTuple):
    """A query that arrived. It ends when the object goes; answer it soon."""

    key: str
    parameters: str
    data: bytes
    encoding: str
    query: zenoh.Query

    def reply(self, data: bytes, encoding: Encoding, key: str | None = None) -> None:
        """Answer with a payload on the asked key, or on one that it matches."""
        self.query.reply(key or self.key, data, encoding=zenoh.Encoding(encoding.value))

    def refuse(self, data: bytes, encoding: Encoding) -> None:
        """Answer with an error reply."""
        self.query.reply_err(data, encoding=zenoh.Encoding(encoding.value))

    def close(self) -> None:
        """End the query: all replies were given."""
        self.query.drop()  # type: ignore[no-untyped-call]


class Presence(NamedTuple):
    """A token that came or went."""

    key: str
    alive: bool


Arrival = Put | TooLong | Ask | Presence


class Inbox:
    """What arrived and was not taken yet. Filled by Zenoh's threads, emptied by one other.

    Attributes:
        dropped: Samples and queries not kept because the inbox was full; tokens are always kept.
        deleted: Samples that were no put, not kept.
    """

    def __init__(self, room: int = 16_384, max_bytes: int = MAX_BYTES, total_bytes: int = 16 * MAX_BYTES) -> None:
        """Make an empty inbox.

        Args:
            room: Arrivals kept at most.
            max_bytes: Longest payload kept.
            total_bytes: Bytes kept at most.
        """
        self.dropped = 0
        self.deleted = 0
        self._room = room
        self._max_bytes = max_bytes
        self._total_bytes = total_bytes
        self._bytes = 0
        self._kept: deque[Arrival] = deque()
        self._some = threading.Condition()

    def _keep(self, arrival: Arrival, length: int) -> None:
        with self._some:
            if length and (len(self._kept) >= self._room or self._bytes + length > self._total_bytes):
                self.dropped += 1
                return
            self._bytes += length
            self._kept.append(arrival)
            self._some.notify()

    def on_sample(self, sample: zenoh.Sample) -> None:
        """Keep a sample. For `declare_subscriber`."""
        if sample.kind != zenoh.SampleKind.PUT:
            self.deleted += 1
            return
        length = len(sample.payload)
        key = str(sample.key_expr)
        if length > self._max_bytes:
            self._keep(TooLong(key, length), 1)
        else:
            self._keep(Put(key, sample.payload.to_bytes(), str(sample.encoding)), length + len(key) + 1)

    def on_query(self, query: zenoh.Query) -> None:
        """Keep a query. For `declare_queryable`."""
        payload = query.payload
        length = 0 if payload is None else len(payload)
        key = str(query.key_expr)
        if length > self._max_bytes:
            self._keep(TooLong(key, length), 1)
            return
        data = b"" if payload is None else payload.to_bytes()
        encoding = "" if query.encoding is None else str(query.encoding)
        self._keep(Ask(key, str(query.parameters), data, encoding, query), length + len(key) + 1)

    def on_token(self, sample: zenoh.Sample) -> None:
        """Keep a token's coming or going. For a liveliness subscriber."""
        self._keep(Presence(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT), 0)

    def take(self) -> list[Arrival]:
        """Return all that arrived, in order of arrival, and forget it."""
        with self._some:
            taken = list(self._kept)
            self._kept.clear()
            self._bytes = 0
        return taken

    def wait(self, seconds: float) -> bool:
        """Wait until something is there, but not longer; return whether it is."""
        with self._some:
            return bool(self._kept) or self._some.wait(max(seconds, 0.0))

    def wake(self) -> None:
        """End a wait from another thread."""
        with self._some:
            self._some.notify_all()


# ---------------------------------------------------------------- presence


def declare_token(session: zenoh.Session, key: str) -> zenoh.LivelinessToken:
    """Return a token: who watches the key sees it come now, and go with the session or `undeclare`."""
    return session.liveliness().declare_token(key)


def watch_tokens(session: zenoh.Session, key: str, inbox: Inbox) -> zenoh.Subscriber[None]:
    """Put every coming and going of tokens into the inbox, those that are there already first."""
    return session.liveliness().declare_subscriber(key, inbox.on_token, history=True)


def tokens(session: zenoh.Session, key: str, *, timeout: float = 1.0) -> list[str]:
    """Return the keys of all tokens there are now that match, sorted; those that answer in time.

    For a look from outside: who watches the same keys believes the watch, which misses nothing.

    Args:
        session: Where.
        key: Perhaps with wildcards.
        timeout: Seconds to wait.
    """
    found: set[str] = set()

    def on_reply(reply: zenoh.Reply) -> None:
        if (sample := reply.ok) is not None:
            found.add(str(sample.key_expr))

    deadline = time.monotonic() + timeout
    # In sessions that had just begun to watch the key, 3 of 100 askings missed a token that was there (Zenoh 1.10.2),
    # with three of them 1 in 450; in sessions that watch nothing, none in 300.
    for _ in range(_ASKINGS):
        done = threading.Event()
        left = max(deadline - time.monotonic(), 0.05)
        session.liveliness().get(key, zenoh.handlers.Callback(on_reply, done.set), timeout=left)
        while not done.wait(_SLICE) and time.monotonic() < deadline + 0.5:
            pass
        if not found:
            threading.Event().wait(_PAUSE)
    return sorted(found)
