"""The form of an endpoint, `tcp/10.0.0.5:7447`, checked before Zenoh sees it: its own errors are about its insides."""

from __future__ import annotations

import ipaddress
import re
import socket
from collections.abc import Iterable
from typing import Final

from intellwheels_schemas import defaults
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.explain import shown

HOST_PROTOCOLS: Final = ("tcp", "udp", "tls", "quic", "ws")
"""Protocols whose address is a host and a port."""
OTHER_PROTOCOLS: Final = ("serial", "unixsock-stream", "unixpipe", "vsock")
"""Protocols whose address has another form, which Zenoh checks."""

_PORT: Final = defaults.ENDPOINT.rpartition(":")[2]
_LAST_PORT: Final = 65535
_HOST = r"[A-Za-z0-9_](?:[A-Za-z0-9._-]*[A-Za-z0-9])?|\[[0-9A-Fa-f:.]+(?:%[A-Za-z0-9]+)?\]"
_ADDRESS = re.compile(rf"({_HOST}):(\d{{1,5}})(?:[?#].*)?")
_GUESS = re.compile(rf"(?:([A-Za-z]+):?/+)?({_HOST})(?::(\d{{1,5}}))?/*")


def check_endpoint(text: str, option: str) -> None:
    """Check the form of an endpoint. Port 0 is refused: nobody would know which one was picked.

    Args:
        text: The endpoint.
        option: The option that names it, for the error.

    Raises:
        WireError: It is not PROTOCOL/HOST:PORT; the text has the endpoint that was probably meant.
    """
    protocol, _, address = text.partition("/")
    if protocol in OTHER_PROTOCOLS and address:
        return
    found = _ADDRESS.fullmatch(address) if protocol in HOST_PROTOCOLS else None
    if found is not None and 1 <= int(found[2]) <= _LAST_PORT:
        return
    expected = f"{option}: expected an endpoint such as {defaults.ENDPOINT}, got {shown(text)}"
    raise WireError("value", f"{expected}{_hint(text, found)}", option)


def is_loopback(endpoint: str) -> bool:
    """Return whether only this machine can connect to an endpoint; a host name other than localhost counts as wide."""
    protocol, _, address = endpoint.partition("/")
    if protocol in OTHER_PROTOCOLS:
        return protocol != "vsock"
    found = _ADDRESS.fullmatch(address)
    if found is None:
        return False
    host = found[1].strip("[]").partition("%")[0]
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"


def host_of(endpoint: str) -> str:
    """Return the host of an endpoint, without the brackets of an IPv6 address; empty if it has none."""
    found = _ADDRESS.fullmatch(endpoint.partition("/")[2])
    return "" if found is None else found[1].strip("[]")


def check_free(endpoints: Iterable[str]) -> None:
    """Check that the TCP endpoints of this machine can be listened at now.

    Raises:
        ConnectionError: Another program listens at one, or its address is not of this machine.
    """
    for endpoint in endpoints:
        protocol, _, address = endpoint.partition("/")
        found = _ADDRESS.fullmatch(address)
        if protocol != "tcp" or found is None:
            continue
        try:
            _bind(found[1].strip("[]"), int(found[2]))
        except OSError as error:
            raise ConnectionError(cannot_listen(endpoint, (error.strerror or str(error)).lower())) from None


def is_free(host: str, port: int) -> bool:
    """Return whether a program can listen at a TCP port of this machine now; port 0 is always free."""
    try:
        _bind(host, port)
    except OSError:
        return False
    return True


def _bind(host: str, port: int) -> None:
    family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind((host, port))


def cannot_listen(endpoint: str, why: str) -> str:
    """Return in words that nobody can listen at an endpoint.

    Args:
        endpoint: The endpoint, or several.
        why: The reason in the words of the system or of Zenoh.
    """
    if "in use" in why:
        why = (
            "the port is in use, perhaps by another simulator; "
            "choose another with --listen, or join that simulator with --connect"
        )
    return f"cannot listen at {endpoint}: {why}"


def zenoh_reason(text: str) -> str:
    """Return an error text of Zenoh without its last part, a position in Zenoh's source."""
    return text.partition(" at ")[0][:200]


def config_reason(text: str) -> str:
    """Return what Zenoh says about a configuration and its line, without Zenoh's own types and source."""
    found = re.search(r'msg: "(.*?)", location|= (.*?)(?: at /|$)', text, re.DOTALL)
    line = re.search(r"line: (\d+)|--> (\d+):", text)
    words = (found[1] or found[2]) if found is not None else zenoh_reason(text)
    return f"in line {line[1] or line[2]}: {words}" if line is not None else words


def _hint(text: str, found: re.Match[str] | None) -> str:
    if found is not None:
        return f"; a port is 1 to {_LAST_PORT}"
    guess = _GUESS.fullmatch(text)
    # A single word may be anything; with a port, a protocol or dots it is meant as an address.
    if guess is None or not (guess[1] or guess[3] or "." in text or text == "localhost"):
        return ""
    protocol = guess[1] if guess[1] in HOST_PROTOCOLS else "tcp"
    port = guess[3] if guess[3] and 0 < int(guess[3]) <= _LAST_PORT else _PORT
    return f"; did you mean {protocol}/{guess[2]}:{port}?"
