"""Counts the sessions of each certificate, or of each address, at a router. Pure. Zenoh counts all sessions together.

The router cannot tell whose password opened a session: Zenoh's events name the owner of a certificate only. A user name
is in its log alone, once a rule has denied something. So without a certificate the address counts.
"""

from __future__ import annotations

from typing import Final

from intellwheels_schemas.endpoint_form import host_of, is_loopback

MAX_SESSIONS: Final = 100
"""Sessions of one certificate, or of one address of another machine, at a time."""


class SessionCount:
    """Counts the links of each certificate or address. Pure.

    Args:
        most: How many each may have; None for `MAX_SESSIONS`, and any number from this machine.
    """

    def __init__(self, most: int | None) -> None:
        self._most = most
        self._links: dict[str, set[str]] = {}
        self._refused: dict[str, int] = {}

    def opened(self, peer: str, certificate: str | None) -> str:
        """Note a link; return in words why it must be closed, empty if it may stay.

        Args:
            peer: Endpoint of the other side, such as `tcp/10.0.0.7:40781`.
            certificate: The common name in its certificate, if it showed one.
        """
        who = certificate or host_of(peer)
        most = MAX_SESSIONS if self._most is None else self._most
        links = self._links.setdefault(who, set())
        if len(links) < most or (self._most is None and certificate is None and is_loopback(peer)):
            links.add(peer)
            return ""
        self._refused[who] = self._refused.get(who, 0) + 1
        return f"closed session of={who} why='it has {most} already' closed={self._refused[who]}"

    def closed(self, peer: str, certificate: str | None) -> None:
        """Note that a link has ended."""
        who = certificate or host_of(peer)
        links = self._links.get(who, set())
        links.discard(peer)
        if not links:
            self._links.pop(who, None)

    @staticmethod
    def is_worth_a_line(words: str) -> bool:
        """Return whether a refusal is the 1st, 10th, 100th and so on of its kind."""
        return words.rpartition("=")[2].rstrip("0") == "1"
