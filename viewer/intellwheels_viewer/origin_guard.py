"""Accepts connections only from our own page under an allowed host name; everything else gets status 403.

Viser checks neither `Host` nor `Origin`, so any web page in the user's browser could connect to the viewer and control
the simulation. Viser also lets a page publish the viewer on the internet. Both are closed here. A port that is in use
is an error instead of a reason to choose another one.
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
"""Names by which a browser on this machine reaches the page."""

Process = Callable[[ServerConnection, Request], Awaitable[Response | None] | Response | None]


def host_of(value: str | None) -> str | None:
    """Return the name in a `Host` header in lower case, without its port; None if there is none."""
    if not value:
        return None
    try:
        return urlsplit(f"//{value}").hostname
    except ValueError:
        return None


def refusal(host: str | None, origin: str | None, ours: frozenset[str]) -> str | None:
    """Return why a request is refused, or None if it is accepted.

    Args:
        host: The `Host` header: a name and perhaps a port.
        origin: The `Origin` header; programs other than browsers send none.
        ours: The allowed host names.
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
    """Check that a port is free.

    Raises:
        ConnectionError: It is in use, or the address does not belong to this machine.
    """
    if port == 0:
        return
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((host, port))
    except OSError as error:
        why = "the port is in use, perhaps by another viewer" if error.errno == 98 else error.strerror  # EADDRINUSE
        raise ConnectionError(f"cannot serve the page at {host}:{port}: {why}; choose another with --port") from None


def open_server(host: str, port: int, allowed: frozenset[str] = frozenset()) -> viser.ViserServer:
    """Return a web server that serves only our page. Viser's own notices are not printed.

    Args:
        host: Address to listen at.
        port: The port; 0 picks a free one.
        allowed: Further host names that browsers may use, for example behind a proxy.

    Raises:
        ConnectionError: The port is in use.
    """
    check_free(host, port)
    # A browser may leave while we write to it; that is normal.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    ours = LOOPBACK | {name.lower() for name in allowed} | ({host.lower()} - {"0.0.0.0", "::"})  # noqa: S104
    with _guarded(ours), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=port, verbose=False)
    if port not in (0, server.get_port()):
        server.stop()
        raise ConnectionError(
            f"cannot serve the page at {host}:{port}: it was taken just now; choose another with --port"
        )
    for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(message)
    return server


@contextlib.contextmanager
def _guarded(ours: frozenset[str]) -> Iterator[None]:
    """Make servers that are opened meanwhile check each request."""
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
