"""Finds out why a router lets nobody in. Zenoh tells silence, a wrong password and a wrong certificate alike."""

from __future__ import annotations

import re
import socket
import ssl
from pathlib import Path
from typing import Final

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_file import IdentityFile, read_identity

TIMEOUT: Final = 1.0
"""Seconds to wait for each answer."""

_ADDRESS = re.compile(r"(tcp|tls)/\[?([^\]#?]+?)\]?:(\d+)(?:[?#].*)?")


def why_not(endpoint: str, identity: Path | None) -> str:
    """Return in words why a session cannot be opened at an endpoint; empty if nobody listens there, or for no reason.

    Args:
        endpoint: Such as `tls/10.0.0.5:7447`.
        identity: The file that was shown, or None.
    """
    found = _ADDRESS.fullmatch(endpoint)
    if found is None:
        return ""
    protocol, host, port = found[1], found[2], int(found[3])
    try:
        own = None if identity is None else read_identity(identity)
        socket.create_connection((host, port), TIMEOUT).close()
        if own is None or identity is None:
            return f"{endpoint} answers, but not to us: a router of a lab expects --identity FILE, from iw-lab invite"
        asking = f"ask for another file, made with iw-lab invite {own.name}"
        if protocol == "tls" and not own.authority:
            return f"{endpoint} shows a certificate, which {identity} cannot check: {asking}"
        wrong = _tls_error(host, port, own.authority if protocol == "tls" else "")
    except (OSError, WireError):
        return ""
    other = endpoint.removeprefix(protocol)
    if protocol == "tcp" and wrong is None:
        return f"{endpoint} encrypts: connect to tls{other}"
    if protocol == "tls" and isinstance(wrong, ssl.SSLCertVerificationError):
        return _about_certificate(wrong, endpoint, host, own, asking)
    if protocol == "tls" and wrong is not None:
        return f"{endpoint} does not encrypt: connect to tcp{other}"
    return (
        f"{endpoint} refuses {own.name}: {identity} was revoked, is of another lab, or is newer than the router's "
        f"start; {asking}, or restart iw-router"
    )


def _tls_error(host: str, port: int, authority: str) -> OSError | None:
    """Return why a handshake fails, or None. Without an authority any certificate is good."""
    if authority:
        context = ssl.create_default_context(cadata=authority)
    else:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    with socket.create_connection((host, port), TIMEOUT) as connection:
        try:
            context.wrap_socket(connection, server_hostname=host).close()
        except OSError as error:
            return error
    return None


def _about_certificate(
    wrong: ssl.SSLCertVerificationError, endpoint: str, host: str, own: IdentityFile, asking: str
) -> str:
    why = wrong.verify_message.lower()
    if "match" in why:
        return f"the certificate of the router is not for {host}: run iw-lab keys --host {host}, and restart iw-router"
    if "expired" in why:
        return f"the certificate of the router at {endpoint} has expired: run iw-lab keys, and restart iw-router"
    return f"{endpoint} is the router of another lab than {own.lab}: check --connect, or {asking}"
