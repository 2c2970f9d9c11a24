"""The datagrams of one client, at a port of its own. Nothing that arrives stops the process.

What is not obeyed is counted. A line is written for the 1st, 10th, 100th and so on of its kind, as a flood must not
fill the log.
"""

from __future__ import annotations

import select
import socket
import threading
from collections import Counter
from collections.abc import Callable
from typing import Final

Address = tuple[str, int]
"""Host and port."""

LARGEST: Final = 65_535
"""Bytes that are read of a datagram: all of it, so that its length can be reported."""
MOST_STRANGERS: Final = 1000
"""Datagrams of strangers that are passed over at once: some 10 ms of work."""
_STRANGER: Final = "datagram of a stranger"


class Reports:
    """Counts what goes wrong, and writes a line for some of it.

    Args:
        log: Takes lines for the log.
    """

    def __init__(self, log: Callable[[str], None]) -> None:
        self._log = log
        self._counts: Counter[str] = Counter()
        self._lock = threading.Lock()

    def tell(self, what: str, who: str, why: str) -> None:
        """Count something that was not obeyed, and report it if its number is 1, 10, 100 and so on."""
        with self._lock:
            self._counts[what] += 1
            count = self._counts[what]
        if str(count).strip("0") == "1":
            self._log(f"dropped what={what!r} count={count} from={who} why={why!r}")

    @property
    def total(self) -> int:
        """How often something was told."""
        with self._lock:
            return sum(self._counts.values())


class ClientSocket:
    """A port for one client.

    Args:
        host: Address to open it at.
        client: Where the client is. What comes from elsewhere is reported.
        reports: Takes what is not obeyed.

    Raises:
        OSError: There is no port left.
    """

    def __init__(self, host: str, client: Address, reports: Reports) -> None:
        self.client = client
        self._reports = reports
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            self._socket.bind((host, 0))
        except OSError:
            self._socket.close()
            raise

    def fileno(self) -> int:
        """Return the descriptor, for selectors."""
        return self._socket.fileno()

    def send(self, message: bytes) -> None:
        """Send a message. A datagram that cannot be sent is lost, as others are on their way."""
        try:
            self._socket.sendto(message, self.client)
        except OSError as error:
            self._reports.tell("message to a client", shown_address(self.client), str(error))

    def receive(self) -> bytes | None:
        """Return the next datagram of the client, or None if none has arrived, or only those of many strangers."""
        for _ in range(MOST_STRANGERS):
            try:
                data, sender = self._socket.recvfrom(LARGEST)
            except BlockingIOError:
                return None
            except OSError:
                # The client's port is closed, says an answer to what was sent; it may open again.
                continue
            if sender == self.client:
                return data
            self._reports.tell(
                _STRANGER, shown_address(sender), f"expected {shown_address(self.client)}, got {len(data)} bytes"
            )
        return None

    def wait(self, seconds: float) -> bool:
        """Wait for a datagram, and return whether one is there."""
        return bool(select.select([self._socket], [], [], max(seconds, 0.0))[0])

    def close(self) -> None:
        """Close the port."""
        self._socket.close()


def shown_address(address: Address) -> str:
    """Return an address as text."""
    return f"{address[0]}:{address[1]}"
