"""The connection to other processes: sessions, publishers, queries and tokens.

Only this module and `zenoh_inbox` know Zenoh here. Every wait has a deadline and watches the stop event. A put never
fails and never waits.
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
from intellwheels_schemas.zenoh_inbox import Inbox

DEFAULT_WORLD: Final = defaults.WORLD
DEFAULT_ENDPOINT: Final = "tcp/127.0.0.1:7447"
QUEUE_ROOM: Final = 16
"""Batches that a transport queues per priority. With Zenoh's default of 2, lockstep of 20 agents loses measures."""

TRY_EVERY: Final = 1.0
"""Seconds between two attempts to open a session."""

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

# Settings of every session, whatever else is configured.
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
    # An address that swallows packets must not delay a process that was told to stop.
    "transport/unicast/open_timeout": 3000,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Link:
    """How a process connects to others.

    Attributes:
        world: Name of the world that it takes part in.
        listen: Endpoints to listen at; if there are any, the process is a Zenoh peer, else a client.
        connect: Endpoints of a router, or of a simulator that listens.
        config: Zenoh configuration file for everything else, or None.
    """

    world: str = DEFAULT_WORLD
    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    config: Path | None = None

    def where(self) -> str:
        """Return the endpoints of this link, for people."""
        return ", ".join(self.listen + self.connect) or str(self.config or DEFAULT_ENDPOINT)


def add_link_options(parser: argparse.ArgumentParser, *, listens: bool = False) -> None:
    """Add the connection options, which all commands share.

    Args:
        parser: Parser of a command.
        listens: Whether the command listens by default, as the simulator does; else it connects.
    """
    group = parser.add_argument_group("connection")
    if listens:
        said, unsaid = f" (default: {DEFAULT_ENDPOINT}, unless --connect or --config is given)", ""
    else:
        said, unsaid = "", f" (default: {DEFAULT_ENDPOINT}, unless --listen or --config is given)"
    group.add_argument(
        "--world",
        default=DEFAULT_WORLD,
        metavar="NAME",
        help="name of the world; several worlds can share an endpoint (default: main)",
    )
    group.add_argument(
        "--connect", action="append", default=[], metavar="ENDPOINT",
        help=f"connect to a router or a simulator, such as tcp/10.0.0.5:7447; may be repeated{unsaid}",
    )  # fmt: skip
    group.add_argument(
        "--listen", action="append", default=[], metavar="ENDPOINT",
        help=f"listen there, so that others need no router; may be repeated{said}",
    )  # fmt: skip
    group.add_argument(
        "--config", type=Path, metavar="FILE", help="Zenoh configuration file (JSON5) for everything else"
    )
    group.set_defaults(link_listens=listens)


def link_of(options: argparse.Namespace) -> Link:
    """Return the link that the parsed options describe.

    Raises:
        WireError: `value`, if the name of the world is invalid.
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
        ConnectionError: The file is missing or is no configuration, or an endpoint is invalid.
    """
    try:
        config = zenoh.Config() if link.config is None else zenoh.Config.from_file(link.config)
        settings = dict(_SETTINGS)
        if link.listen or link.connect or link.config is None:
            settings["mode"] = "peer" if link.listen else "client"
            settings["listen/endpoints"] = list(link.listen)
            settings["connect/endpoints"] = list(link.connect or (() if link.listen else (DEFAULT_ENDPOINT,)))
        if link.listen:
            # Without these a port in use is only logged.
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
    """Return a session, or None if `stop` was set before one could be opened. Use it in a `with` statement.

    While there is no answer it tries again every second; a port in use fails at once.

    Args:
        link: How to connect.
        stop: Ends the attempts.
        timeout: Seconds after which to give up; None for never.
        waiting: Called once, with the reason, when the first attempt fails.

    Raises:
        ConnectionError: The port is in use, nobody answered in time, or the options are invalid; the text says which.
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
                    f"cannot listen at {taken}: the port is in use, perhaps by another simulator; "
                    "choose another with --listen, or join that simulator with --connect"
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
    """Return the configuration of a router for this contract, as JSON, for `iw-router` and for `zenohd -c`.

    Args:
        listen: Endpoints to listen at, such as `tcp/0.0.0.0:7447`.
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
    """Return a session that is a router: it connects all its clients with each other. Use it in a `with` statement.

    Raises:
        ConnectionError: An endpoint is invalid, or its port is in use; the text says which.
    """
    zenoh.init_log_from_env_or("off")
    try:
        config = zenoh.Config.from_json5(router_settings(listen))
        config.insert_json5("listen/exit_on_failure", "true")
        config.insert_json5("listen/timeout_ms", "0")
        return zenoh.open(config)
    except (zenoh.ZError, ValueError) as error:
        why = "the port is in use" if "in use" in str(error) else _reason(error)
        raise ConnectionError(f"cannot listen at {', '.join(listen)}: {why}") from None


def _until(moment: float, deadline: float | None) -> float:
    return min(moment, moment if deadline is None else deadline) - time.monotonic()


def _reason(error: Exception) -> str:
    # Zenoh's texts end with the position in its own source.
    return str(error).partition(" at ")[0][:200]


# ---------------------------------------------------------------- out


def declare(session: zenoh.Session, key: str, channel: Channel, encoding: Encoding = Encoding.JSON) -> zenoh.Publisher:
    """Return a publisher for a key, with the priority of its channel. A put without one costs 65 µs by a router."""
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
        key: Key of the reply; empty for an error reply.
        data: The payload.
        encoding: Its encoding, as text.
        ok: False for an error reply.
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
    """Send a query, and return all replies, at least one.

    Args:
        session: Session to use.
        selector: Key, possibly with wildcards and parameters (`event?since=7`).
        data: Payload of the query, or None.
        encoding: Encoding of `data`, and the one wanted for the replies.
        timeout: Seconds to wait.
        stop: Ends the wait.

    Raises:
        ConnectionError: There was no reply: there is no simulator, or access is not allowed; Zenoh does not say which.
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
        # The parts of a state are several replies from one writer, and none of them replaces another.
        consolidation=zenoh.ConsolidationMode.NONE,
        target=zenoh.QueryTarget.ALL,
        timeout=timeout,
        payload=data if data is not None else b"",
        encoding=zenoh.Encoding(encoding.value),
    )
    # Zenoh ends the query at its own time-out; it gets half a second more to do so.
    deadline = time.monotonic() + timeout + 0.5
    while not done.wait(_SLICE) and time.monotonic() < deadline and (stop is None or not stop.is_set()):
        pass
    if not answers:
        raise ConnectionError(f"no simulator at {selector.partition('?')[0]}, or not allowed")
    return list(answers)


# ---------------------------------------------------------------- presence


def declare_token(session: zenoh.Session, key: str) -> zenoh.LivelinessToken:
    """Return a new liveliness token. Watchers of the key see it disappear with the session or with `undeclare`."""
    return session.liveliness().declare_token(key)


def watch_tokens(session: zenoh.Session, key: str, inbox: Inbox) -> zenoh.Subscriber[None]:
    """Put every token that appears or disappears into the inbox, beginning with those that exist already."""
    return session.liveliness().declare_subscriber(key, inbox.on_token, history=True)


def tokens(session: zenoh.Session, key: str, *, timeout: float = 1.0) -> list[str]:
    """Return the keys of all matching tokens that answer in time, sorted.

    For a single look. To follow tokens use `watch_tokens`, which misses none.

    Args:
        session: Session to use.
        key: Key, possibly with wildcards.
        timeout: Seconds to wait.
    """
    found: set[str] = set()

    def on_reply(reply: zenoh.Reply) -> None:
        if (sample := reply.ok) is not None:
            found.add(str(sample.key_expr))

    deadline = time.monotonic() + timeout
    # In a session that has just begun to watch the key, 3 of 100 queries missed an existing token (Zenoh 1.10.2), and 1
    # of 450 triples of queries did; in sessions that watch nothing, none of 300.
    for _ in range(_ASKINGS):
        done = threading.Event()
        left = max(deadline - time.monotonic(), 0.05)
        session.liveliness().get(key, zenoh.handlers.Callback(on_reply, done.set), timeout=left)
        while not done.wait(_SLICE) and time.monotonic() < deadline + 0.5:
            pass
        if not found:
            threading.Event().wait(_PAUSE)
    return sorted(found)
