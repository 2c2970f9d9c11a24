"""Accepts connections only from our own page under an allowed host name; everything else gets status 403.

Viser checks neither `Host` nor `Origin`, so any web page in the user's browser could connect to the viewer and control
the simulation. Viser also lets a page publish the viewer on the internet, and fill its memory with files. All of it is
closed here. A port that is in use
is an error instead of a reason to choose another one.
"""

from __future__ import annotations

import contextlib
import functools
import http
import io
import socket
import warnings
from collections.abc import Awaitable, Callable, Iterator, Mapping
from typing import Any

import viser
import websockets.asyncio.server
from viser import _messages
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from intellwheels_viewer.page_hosts import PageNames, page_names, refusal

MAX_MESSAGE = 1 << 20
"""Longest message of a page, in bytes. Viser's own bound is 50 MB; our pages send a few hundred bytes."""

Process = Callable[[ServerConnection, Request], Awaitable[Response | None] | Response | None]


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
        allowed: Further host names that browsers may use, for example behind a proxy; perhaps with a port.

    Raises:
        ConnectionError: The port is in use.
    """
    check_free(host, port)
    # A browser may leave while we write to it; that is normal.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    ours = page_names(host, allowed)
    with _guarded(ours), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=port, verbose=False)
    if port not in (0, server.get_port()):
        server.stop()
        raise ConnectionError(
            f"cannot serve the page at {host}:{port}: it was taken just now; choose another with --port"
        )
    for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(message)
    _close_uploads(server.gui)
    return server


def admit(client: viser.ClientHandle, server: viser.ViserServer) -> Mapping[str, str]:
    """Close what a browser that has just connected does not need; return the headers of its request.

    Of a header that came twice, the values are joined by a comma.
    """
    _close_uploads(client.gui)
    request = server._websock_server._live_connections[client.client_id].request
    headers = Headers() if request is None else request.headers
    return {name.lower(): ",".join(headers.get_all(name)) for name in headers}


def _close_uploads(gui: viser.GuiApi) -> None:
    """Take no files: viser keeps in memory what is uploaded, without a bound, to an element of any kind."""
    for message in (_messages.FileTransferStartUpload, _messages.FileTransferPart):
        gui._websock_interface.unregister_handler(message)


@contextlib.contextmanager
def _guarded(ours: PageNames) -> Iterator[None]:
    """Make servers that are opened meanwhile check each request."""
    real = websockets.asyncio.server.serve

    @functools.wraps(real)
    def serve(*args: Any, process_request: Process | None = None, **named: Any) -> Any:
        return real(*args, process_request=_checked(process_request, ours), **{**named, "max_size": MAX_MESSAGE})

    websockets.asyncio.server.serve = serve  # type: ignore[assignment,misc]
    try:
        yield
    finally:
        websockets.asyncio.server.serve = real  # type: ignore[misc]


def _checked(inner: Process | None, ours: PageNames) -> Process:
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
