"""The connection to other processes: sessions, publishers, queries and tokens.

In this package only this module and `zenoh_inbox` use Zenoh. Every wait has a deadline and checks the stop event. A put
never fails and never waits.
"""

from __future__ import annotations

import argparse
import json
import os
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

import zenoh

from intellwheels_schemas import defaults
from intellwheels_schemas.channels import Channel
from intellwheels_schemas.codec import MAX_BYTES, Encoding, is_known
from intellwheels_schemas.command_parser import readable_file
from intellwheels_schemas.endpoint_form import cannot_listen, check_endpoint, config_reason, zenoh_reason
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_file import keep_out_of_logs, read_identity
from intellwheels_schemas.identity_option import add_identity_option, check_option, router_of
from intellwheels_schemas.names import check_name
from intellwheels_schemas.own_rights import remember, unanswered
from intellwheels_schemas.session_closing import asking
from intellwheels_schemas.zenoh_inbox import Inbox

QUEUE_ROOM: Final = 16
"""Batches in a transport's queue, per priority. With Zenoh's default of 2, lockstep of 20 agents loses measures."""

TRY_EVERY: Final = 1.0
"""Seconds between two attempts to open a session."""

START_ONE: Final = "start a simulator (iw-server) or a router there, or name another with --connect or --identity"
"""What somebody who waits can do."""

_SLICE: Final = 0.2  # s: longest single wait, so that signals are handled
_ASKINGS: Final = 3
_PAUSE: Final = 0.02

_PRIORITIES: Final[dict[str, zenoh.Priority]] = {
    "real-time": zenoh.Priority.REAL_TIME,
    "interactive-high": zenoh.Priority.INTERACTIVE_HIGH,
    "data-high": zenoh.Priority.DATA_HIGH,
    "data": zenoh.Priority.DATA,
    "data-low": zenoh.Priority.DATA_LOW,
}

# Settings of every session. They override the configuration file.
SETTINGS: Final[dict[str, Any]] = {
    "scouting/multicast/enabled": False,
    # Gossip lets peers connect directly and so avoid a router's access control.
    "scouting/gossip/enabled": False,
    "transport/shared_memory/enabled": False,
    "transport/link/rx/max_message_size": MAX_BYTES,
    "transport/link/tx/queue/size": {
        "control": QUEUE_ROOM, "real_time": QUEUE_ROOM, "interactive_high": QUEUE_ROOM,
        "interactive_low": QUEUE_ROOM, "data_high": QUEUE_ROOM, "data": QUEUE_ROOM, "data_low": QUEUE_ROOM,
        "background": QUEUE_ROOM,
    },
    # An address that drops packets must not delay the end of a process.
    "transport/unicast/open_timeout": 3000,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Link:
    """The connection of a process to others.

    Attributes:
        world: Name of the world that it joins.
        listen: Endpoints to listen at. With any, the process is a Zenoh peer; without, a client.
        connect: Endpoints of a router, or of a simulator that listens.
        config: Zenoh configuration file for all other settings, or None.
        identity: The file with the name, password and certificate for the router, or None.
    """

    world: str = defaults.WORLD
    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    config: Path | None = None
    identity: Path | None = None

    def where(self) -> str:
        """Return the endpoints of this link, for people."""
        return ", ".join(self.listen + self.connect) or str(self.config or defaults.ENDPOINT)


def add_link_options(parser: argparse.ArgumentParser, *, listens: bool = False, world: str = defaults.WORLD) -> None:
    """Add the connection options, which all commands share.

    Args:
        parser: Parser of a command.
        listens: Whether the command listens by default, as the simulator does; otherwise it connects.
        world: The default of --world in words, if the command sets another than `defaults.WORLD`.
    """
    group = parser.add_argument_group("connection")
    if listens:
        said = f" (default: {defaults.ENDPOINT}, unless --connect, --config or an --identity with endpoints is given)"
        unsaid = " (default: the endpoints of --identity, or none)"
    else:
        said = ""
        unsaid = (
            f" (default: the endpoints of --identity, or {defaults.ENDPOINT}; none if --listen or --config is given)"
        )
    group.add_argument(
        "--world",
        default=defaults.WORLD,
        metavar="NAME",
        help=f"name of the world; several worlds can share an endpoint (default: {world})",
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
        "--config", type=readable_file, metavar="FILE", help="Zenoh configuration file (JSON5) for everything else"
    )
    add_identity_option(group)
    group.set_defaults(link_listens=listens)


def link_of(options: argparse.Namespace) -> Link:
    """Return the link that the parsed options describe.

    Raises:
        WireError: `value`, if the name of the world, an endpoint or the configuration file is invalid.
    """
    listen, connect = tuple(options.listen), tuple(options.connect)
    if not listen and not connect and options.config is None:
        connect = router_of(options.identity)
    if not listen and not connect and options.config is None:
        if options.link_listens:
            listen = (defaults.ENDPOINT,)
        else:
            connect = (defaults.ENDPOINT,)
    link = Link(check_name(options.world, "--world"), listen, connect, options.config, options.identity)
    check_link(link)
    return link


def check_link(link: Link) -> None:
    """Check the endpoints, the identity and the configuration file of a link that options describe.

    An identity that ends soon, or that others can read, gives a warning on standard error.

    Raises:
        WireError: One is invalid, or the identity has expired; the text names the option.
    """
    if link.identity is not None:
        check_option(link.identity)
    for endpoint in link.connect:
        check_endpoint(endpoint, "--connect")
    for endpoint in link.listen:
        check_endpoint(endpoint, "--listen")
    if link.config is None:
        return
    try:
        config_of(link)
    except ConnectionError as error:
        raise WireError("value", f"--config: {error}", "--config") from None


def config_of(link: Link) -> zenoh.Config:
    """Return the Zenoh configuration of a link.

    Raises:
        ConnectionError: The file is missing or is not a configuration, or an endpoint is invalid.
    """
    try:
        config = zenoh.Config() if link.config is None else zenoh.Config.from_file(link.config)
        settings = dict(SETTINGS)
        if link.listen or link.connect or link.config is None:
            settings["mode"] = "peer" if link.listen else "client"
            settings["listen/endpoints"] = list(link.listen)
            settings["connect/endpoints"] = list(link.connect or (() if link.listen else (defaults.ENDPOINT,)))
        if link.listen:
            # Without these settings, Zenoh only logs that a port is in use.
            settings["listen/exit_on_failure"] = True
            settings["listen/timeout_ms"] = 0
        if link.identity is not None:
            settings |= read_identity(link.identity).settings()
        for key, value in settings.items():
            config.insert_json5(key, json.dumps(value))
    except WireError as error:
        raise ConnectionError(error.text) from None
    except (zenoh.ZError, OSError, ValueError) as error:
        where = "link" if link.config is None else str(link.config)
        wrong = config_reason(str(error))
        raise ConnectionError(f"{where}: expected a Zenoh configuration and endpoints, got {wrong}") from None
    return config


def open_session(
    link: Link,
    stop: threading.Event,
    *,
    timeout: float | None = None,
    waiting: Callable[[str], None] | None = None,
) -> zenoh.Session | None:
    """Return a session, or None if `stop` was set before one could be opened. Use it in a `with` statement.

    Without an answer it tries again every second. If a port is in use, it fails at once.

    Args:
        link: How to connect.
        stop: Ends the attempts.
        timeout: Seconds after which it gives up; None for never.
        waiting: Called once, with the reason and what to do, when the first attempt fails.

    Raises:
        ConnectionError: The port is in use, there was no answer in time, or the options are invalid, as the text says.
    """
    deadline = None if timeout is None else time.monotonic() + timeout
    keep_out_of_logs(os.environ)
    zenoh.init_log_from_env_or("off")
    config = config_of(link)
    while not stop.is_set():
        began = time.monotonic()
        try:
            session = zenoh.open(config)
        except zenoh.ZError as error:
            if link.listen:
                raise ConnectionError(cannot_listen(", ".join(link.listen), zenoh_reason(str(error)))) from None
            words = _why_not(link)
        else:
            if link.identity is not None:
                remember(session, read_identity(link.identity))
            return session
        if waiting is not None:
            waiting(f"{words}; {START_ONE}" if words.startswith("nobody") else words)
            waiting = None
        if deadline is not None and time.monotonic() >= deadline:
            raise ConnectionError(words)
        again = began + TRY_EVERY if deadline is None else min(began + TRY_EVERY, deadline)
        while not stop.is_set() and (left := again - time.monotonic()) > 0:
            stop.wait(min(left, _SLICE))
    return None


def _why_not(link: Link) -> str:
    """Return in words why no session could be opened. Zenoh tells all reasons alike."""
    from intellwheels_schemas.router_probe import why_not  # noqa: PLC0415 - sockets, after a failure only

    return why_not(next(iter(link.connect), ""), link.identity) or f"nobody answers at {link.where()}"


# ---------------------------------------------------------------- out


def declare(session: zenoh.Session, key: str, channel: Channel, encoding: Encoding = Encoding.JSON) -> zenoh.Publisher:
    """Return a publisher for a key, with the priority of its channel.

    Through a router, a put without a publisher takes 65 µs.
    """
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
        replier: Zenoh's id of the session that replied; empty if Zenoh does not tell.
    """

    key: str
    data: bytes
    encoding: str
    ok: bool
    replier: str = ""


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
        encoding: Encoding of `data` and of the replies.
        timeout: Seconds to wait.
        stop: Ends the wait.

    Raises:
        NotAllowedError: There was no reply, as this session may not ask that.
        ConnectionError: There was no reply. Or another thread closes the session.
    """
    answers: deque[Answer] = deque()
    done = threading.Event()

    def on_reply(reply: zenoh.Reply) -> None:
        replier = "" if reply.replier_id is None else str(reply.replier_id.zid)
        if (sample := reply.ok) is not None:
            data = sample.payload.to_bytes()
            answers.append(Answer(str(sample.key_expr), data, str(sample.encoding), True, replier))
        elif (error := reply.err) is not None and is_known(str(error.encoding)):
            answers.append(Answer("", error.payload.to_bytes(), str(error.encoding), False, replier))

    with asking(session):
        session.get(
            selector,
            zenoh.handlers.Callback(on_reply, done.set),
            # The parts of a state are several replies from one writer, and no part replaces another.
            consolidation=zenoh.ConsolidationMode.NONE,
            target=zenoh.QueryTarget.ALL,
            timeout=timeout,
            payload=data if data is not None else b"",
            encoding=zenoh.Encoding(encoding.value),
        )
    # Zenoh ends the query at its own time-out, so this wait is half a second longer.
    deadline = time.monotonic() + timeout + 0.5
    while not done.wait(_SLICE) and time.monotonic() < deadline and (stop is None or not stop.is_set()):
        pass
    if not answers:
        raise unanswered(session, selector.partition("?")[0])
    return list(answers)


# ---------------------------------------------------------------- presence


def declare_token(session: zenoh.Session, key: str) -> zenoh.LivelinessToken:
    """Return a new liveliness token. It disappears when the session closes or with `undeclare`."""
    return session.liveliness().declare_token(key)


def watch_tokens(session: zenoh.Session, key: str, inbox: Inbox) -> zenoh.Subscriber[None]:
    """Put every token that appears or disappears into the inbox, and first all tokens that exist already."""
    return session.liveliness().declare_subscriber(key, inbox.on_token, history=True)


def look_for_tokens(session: zenoh.Session, key: str, inbox: Inbox, *, timeout: float = 1.0) -> None:
    """Put every token that answers in time into the inbox, without waiting.

    A watch does not report what appeared while its session was cut off from the network; this does.
    """
    session.liveliness().get(key, inbox.on_token_reply, timeout=timeout)


def tokens(session: zenoh.Session, key: str, *, timeout: float = 1.0) -> list[str]:
    """Return the sorted keys of all matching tokens that are reported in time.

    Use it for a single check. To follow tokens, use `watch_tokens`, which misses none.

    Args:
        session: Session to use.
        key: Key, possibly with wildcards.
        timeout: Seconds to wait.

    Raises:
        ConnectionError: Another thread closes the session.
    """
    found: set[str] = set()

    def on_reply(reply: zenoh.Reply) -> None:
        found.update(() if reply.ok is None else (str(reply.ok.key_expr),))

    deadline = time.monotonic() + timeout
    # In a session that has just started to watch the key, 3 of 100 queries missed an existing token (Zenoh 1.10.2), as
    # did 1 of 450 triples of queries. In sessions that watch nothing, none of 300 queries did.
    for _ in range(_ASKINGS):
        done = threading.Event()
        left = max(deadline - time.monotonic(), 0.05)
        with asking(session):
            session.liveliness().get(key, zenoh.handlers.Callback(on_reply, done.set), timeout=left)
        while not done.wait(_SLICE) and time.monotonic() < deadline + 0.5:
            pass
        if not found:
            threading.Event().wait(_PAUSE)
    return sorted(found)
