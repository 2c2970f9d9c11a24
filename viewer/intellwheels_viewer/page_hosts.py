"""The names and addresses of the page, checked before anything starts."""

from __future__ import annotations

import re
import socket
from collections.abc import Iterable
from typing import Final

from intellwheels_schemas.errors import WireError

_NAME: Final = re.compile(r"[A-Za-z0-9_](?:[A-Za-z0-9._-]*[A-Za-z0-9])?|[0-9A-Fa-f]*(?::[0-9A-Fa-f.]*){2,}")
"""A host name or an IP address, without a port. An address with a colon has at least two."""


def check_page_hosts(host: str, allowed: Iterable[str]) -> None:
    """Check where the page is served, and by which names browsers may reach it.

    Raises:
        WireError: `--host` is no address of this machine, or a name of `--allow-host` has another form.
    """
    for name in allowed:
        if _NAME.fullmatch(name) is None:
            text = f"--allow-host: expected a host name such as lab-pc, without a port, got {name!r}"
            raise WireError("value", text, "--allow-host")
    if not _is_here(host):
        text = f"--host: expected an address of this machine, such as 127.0.0.1 or 0.0.0.0, got {host!r}"
        raise WireError("value", text, "--host")


def _is_here(host: str) -> bool:
    if _NAME.fullmatch(host) is None:
        return False
    try:
        family, kind, _, _, address = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind) as probe:
            probe.bind(address)
    except OSError:
        return False
    return True
