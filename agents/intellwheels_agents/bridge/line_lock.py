"""A lock that keeps a second bridge off a line that has no device file to lock: a network address or a CAN channel.

It is a socket in Linux's abstract name space, as CAN interfaces are names in the same network name space. The system
releases it when the process ends, however it ends.
"""

from __future__ import annotations

import socket


class LineLock:
    """A lock with a name. One process at a time has it."""

    def __init__(self, name: str) -> None:
        """Prepare a lock; `name` says which line it is, such as `rnet/socketcan/can0`."""
        # The system takes 107 bytes after the zero that marks an abstract name.
        self._address = b"\0" + f"iw-bridge/{name}".encode()[:107]
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
