"""A router: its settings, the session that is one, and the sessions of others that it closes."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import stat
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import zenoh

from intellwheels_schemas.endpoint_form import is_loopback, zenoh_reason
from intellwheels_schemas.identity_file import keep_out_of_logs
from intellwheels_schemas.link import SETTINGS
from intellwheels_schemas.session_count import SessionCount

OPEN: Final = (
    "open: no access rules, so whoever connects can act for anybody, and can end a simulator by an earlier claim to "
    "its world"
)
"""What a router without rules, and a simulator without an identity, says at every start."""
_OPEN_FILES: Final = Path("/dev/fd")
_DOOR: Final[dict[str, Any]] = {
    # Connections that say nothing take the place of others. Zenoh's defaults are 100 of them, for 10 s each.
    "transport/unicast/accept_pending": 1000,
    "transport/unicast/accept_timeout": 3000,
}


def open_words(listen: Sequence[str]) -> str:
    """Return what a process without rules says at every start: also whether other machines can connect to it."""
    wide = [endpoint for endpoint in listen if not is_loopback(endpoint)]
    return f"{OPEN}; other machines too, at {', '.join(wide)}" if wide else OPEN


def router_settings(listen: Sequence[str], more: Mapping[str, Any] | None = None) -> str:
    """Return the configuration of a router for this contract, as JSON, for `iw-router` and for `zenohd -c`.

    Args:
        listen: Endpoints to listen at, such as `tcp/0.0.0.0:7447`.
        more: Further settings by their paths, such as `access_control`.
    """
    nested: dict[str, Any] = {}
    settings = {**SETTINGS, **_DOOR, "mode": "router", "listen/endpoints": list(listen), **(more or {})}
    for key, value in settings.items():
        *path, last = key.split("/")
        place = nested
        for part in path:
            place = place.setdefault(part, {})
        place[last] = value
    return json.dumps(nested, indent=2) + "\n"


def open_router(listen: Sequence[str], more: Mapping[str, Any] | None = None, log: str = "off") -> zenoh.Session:
    """Return a session that is a router, which connects its clients with each other. Use it in a `with` statement.

    Args:
        listen: Endpoints to listen at.
        more: As for `router_settings`.
        log: What Zenoh logs if `RUST_LOG` does not say it.

    Raises:
        ConnectionError: An endpoint is invalid, or its port is in use, as the text says.
    """
    keep_out_of_logs(os.environ)
    zenoh.init_log_from_env_or(log)
    try:
        config = zenoh.Config.from_json5(router_settings(listen, more))
        config.insert_json5("listen/exit_on_failure", "true")
        config.insert_json5("listen/timeout_ms", "0")
        return zenoh.open(config)
    except (zenoh.ZError, ValueError) as error:
        why = "the port is in use; choose another with --listen" if "in use" in str(error) else zenoh_reason(str(error))
        raise ConnectionError(f"cannot listen at {', '.join(listen)}: {why}") from None


def guard_sessions(session: zenoh.Session, most: int | None, tell: Callable[[str], None]) -> Any:
    """Close the sessions beyond a number, and tell of them. Return the listener, to be kept.

    Args:
        session: A session that is a router.
        most: As for `SessionCount`.
        tell: Called with a line, on a thread of Zenoh.
    """
    count = SessionCount(most)

    def on_link(event: zenoh.LinkEvent) -> None:
        own, peer, certificate = event.link.src, event.link.dst, event.link.auth_identifier
        if event.kind == zenoh.SampleKind.DELETE:
            count.closed(peer, certificate)
        elif words := count.opened(peer, certificate):
            shut(own, peer)
            if count.is_worth_a_line(words):
                tell(words)

    return session.info.declare_link_events_listener(on_link, history=True)


def shut(own: str, peer: str) -> bool:
    """Shut the connection of this process between two endpoints; return whether there is one."""
    for file in _OPEN_FILES.iterdir():
        with contextlib.suppress(OSError):
            if not stat.S_ISSOCK(os.fstat(number := int(file.name)).st_mode):
                continue
            # A copy, so that closing it does not close Zenoh's.
            with socket.socket(fileno=os.dup(number)) as connection:
                if connection.family not in (socket.AF_INET, socket.AF_INET6):
                    continue
                ends = _end(connection.getsockname()), _end(connection.getpeername())
                if ends == (own.partition("/")[2], peer.partition("/")[2]):
                    connection.shutdown(socket.SHUT_RDWR)
                    return True
    return False


def _end(address: Any) -> str:
    host, port = address[:2]
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
