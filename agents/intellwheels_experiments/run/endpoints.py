"""Free TCP ports of this machine, for worlds that need an address of their own."""

from __future__ import annotations

import socket


def free_port() -> int:
    """Return a TCP port of 127.0.0.1 that is free now.

    The operating system chooses it. Another process may take it before the caller does.
    """
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def free_endpoint() -> str:
    """Return a Zenoh endpoint at a free port of this machine, such as `tcp/127.0.0.1:41234`."""
    return f"tcp/127.0.0.1:{free_port()}"
