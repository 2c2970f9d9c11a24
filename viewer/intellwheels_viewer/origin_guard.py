"""Who may talk to the page: our own page, at a host that is ours. Everybody else gets 403 before a word is exchanged.

Viser checks neither `Host` nor `Origin`, so any web page in the user's browser could connect to the viewer and steer;
and it lets a page publish the viewer on the internet. Both are closed here, and a port that is taken is said in words
instead of another one being used.
"""

from __future__ import annotations

import contextlib
import functools
import http
import io
import socket
import warnings
from collections.abc import Awaitable, Callable, Iterator
from typing import Any
from urllib.parse import urlsplit

import viser
import websockets.asyncio.server
from viser import _messages
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

LOOPBACK = frozenset({"localhost", "127.0.0.1", "::1"})
"""Names under which a browser on this machine reaches us."""

Process = Callable[[ServerConnection, Request], Awaitable[Response | None] | Response | None]


def host_of(value: str | None) -> str | None:
    """Return the name in a `Host` header, without its port and in lower case; None where there is none."""
    if not value:
        return None
    try:
        return urlsplit(f"//{value}").hostname
    except ValueError:
        return None


def refusal(host: str | None, origin: str | None, ours: frozenset[str]) -> str | None:
    """Return why a request is refused, or None when it is welcome.

    Args:
        host: The `Host` header: a name and perhaps a port.
        origin: The `Origin` header; programs that are no browser send none.
        ours: Names we are reached by.
    """
    name = host_of(host)
    if name is None or name not in ours:
        return f"Host: expected one of {', '.join(sorted(ours))}, got {host!r}; see --allow-host"
    if origin is not None:
        try:
            parts = urlsplit(origin)
        except ValueError:
            return f"Origin: expected this page's own, {host!r}, got {origin!r}"
        if parts.netloc.lower() != (host or "").lower() or parts.scheme not in ("http", "https"):
            return f"Origin: expected this page's own, {host!r}, got {origin!r}"
    return None


def check_free(host: str, port: int) -> None:
    """Return when a port can be had.

    Raises:
        ConnectionError: In words: it is taken, or the address is none of ours.
    """
    if port == 0:
        return
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((host, port))
    except OSError as error:
        why = "it is taken, perhaps by another viewer" if error.errno == 98 else error.strerror  # EADDRINUSE
        raise ConnectionError(f"cannot serve the page at {host}:{port}: {why}; give another with --port") from None


def open_server(host: str, port: int, allowed: frozenset[str] = frozenset()) -> viser.ViserServer:
    """Return a server that serves our page only. Its own notices are not printed.

    Args:
        host: Address to listen at.
        port: 0 for any free one.
        allowed: Further names by which a browser may reach us, as behind a proxy.

    Raises:
        ConnectionError: The port is taken.
    """
    check_free(host, port)
    # A browser leaves while something is written to it: that is no news.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    ours = LOOPBACK | {name.lower() for name in allowed} | ({host.lower()} - {"0.0.0.0", "::"})  # noqa: S104
    with _guarded(ours), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=port, verbose=False)
    if port not in (0, server.get_port()):
        server.stop()
        raise ConnectionError(
            f"cannot serve the page at {host}:{port}: it was taken just now; give another with --port"
        )
    for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(message)
    return server


@contextlib.contextmanager
def _guarded(ours: frozenset[str]) -> Iterator[None]:
    """Let servers that are opened meanwhile ask us about each request."""
    real = websockets.asyncio.server.serve

    @functools.wraps(real)
    def serve(*args: Any, process_request: Process | None = None, **named: Any) -> Any:
        return real(*args, process_request=_checked(process_request, ours), **named)

    websockets.asyncio.server.serve = serve  # type: ignore[assignment,misc]
    try:
        yield
    finally:
        websockets.asyncio.server.serve = real  # type: ignore[misc]


def _checked(inner: Process | None, ours: frozenset[str]) -> Process:
    async def process(connection: ServerConnection, request: Request) -> Response | None:
        hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        why = refusal(hosts[0] if len(hosts) == 1 else None, ",".join(origins) if origins else None, ours)
        if why is not None:
            return connection.respond(http.HTTPStatus.FORBIDDEN, why + "\n")
        if inner is None:
            return None
        answer = inner(connection, request)
        return await answer if isinstance(answer, Awaitable) else answer

    return process
