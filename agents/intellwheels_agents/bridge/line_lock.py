"""A lock that keeps a second bridge off a line that has no device file to lock: a network address or a CAN channel.

It is a socket in Linux's abstract name space, as CAN interfaces are names in the same network name space. The system
releases it when the process ends, however it ends.
"""

from __future__ import annotations

import hashlib
import socket


class LineLock:
    """A lock with a name. One process at a time has it."""

    def __init__(self, name: str) -> None:
        """Prepare a lock; `name` says which line it is, such as `rnet/socketcan/can0`."""
        # The system takes 107 bytes after the zero that marks an abstract name. A digest fits, whatever the name.
        self._address = b"\0iw-bridge/" + hashlib.sha256(name.encode()).hexdigest().encode()
        self._socket: socket.socket | None = None

    def take(self) -> bool:
        """Take the lock; return False if another process or driver has it."""
        holder = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            holder.bind(self._address)
        except OSError:
            holder.close()
            return False
        self._socket = holder
        return True

    def release(self) -> None:
        """Release the lock, if it is taken."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def names_of(address: str) -> list[str]:
    """Return HOST:PORT and the network addresses behind it, sorted; without an answer, HOST:PORT alone.

    A chair has one lock for each, so that a host name and its address exclude each other. This may wait for DNS.
    """
    host, _, port = address.rpartition(":")
    names = {address.lower()}
    try:
        found = socket.getaddrinfo(host.strip("[]"), int(port), type=socket.SOCK_STREAM)
    except (OSError, UnicodeError):
        return sorted(names)
    return sorted(
        names | {f"[{one[4][0]}]:{port}" if one[0] == socket.AF_INET6 else f"{one[4][0]}:{port}" for one in found}
    )
