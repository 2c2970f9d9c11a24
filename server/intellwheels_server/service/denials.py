"""What the router of a lab denied, from the lines that Zenoh logs about its rules. Pure. Zenoh tells it nowhere else.

Zenoh logs what the rules say of a message, and then, on the same thread, that it drops the message. For each declared
key it also logs what the rules would say of other messages; no drop follows these.
"""

from __future__ import annotations

import re
from collections import Counter
from typing import Final

from intellwheels_schemas.rights import sentence

LOG: Final = (
    "zenoh::net::routing::interceptor=trace,zenoh_transport::unicast::establishment::accept=debug,"
    "zenoh_link_tls::unicast=warn"
)
"""The parts of Zenoh's log that are read. Without colours a line could not be told from the text of a peer."""
MOST: Final = 100
"""Different denials of one identity that are told apart. Others are counted together."""
SOMEBODY: Final = "somebody"

_LINE: Final = b"\x1b["
"""How each line begins. Zenoh escapes this in the text of peers, but not the end of a line."""
_DROPPED: Final = b"Msg intercepted!"
_NOT_LET_IN: Final = {
    b"UsrPwd extension - Recv InitSyn. Expected": "showed no identity",
    b"UsrPwd extension - Recv OpenSyn. Invalid": "showed an unknown name or a wrong password",
    b"invalid peer certificate: UnknownIssuer": "showed a certificate of another lab",
    b"invalid peer certificate: certificate expired": "showed a certificate that has expired",
    b"peer sent no certificates": "showed no certificate",
    b"received fatal alert: UnknownCA": "is of no lab or another one, and did not accept the router's certificate",
}
"""Words of Zenoh and of its TLS for who is not let in. They do not tell who it is."""
_ACCEPTS: Final = (b"::accept\x1b", b"zenoh_link_tls")
_MESSAGE: Final = b"\x1b[2m:\x1b[0m "
"""What stands between the thread and part of Zenoh and the message, of which a key with any text is the end."""
_REFUSES: Final = re.compile(rb"([0-9a-f]{1,32}) on (.*?) is unauthorized to ")
_NAME: Final = re.compile(rb"(?:Username|CertCommonName)\(([^)]{1,64})\)")
_DENIED: Final = re.compile(
    rb"(?:Using cached result: )?([0-9a-f]{1,32})(?: on (.*?))? is (un)?authorized to ([A-Z][a-zA-Z ]*) "
    rb"\(ingress\) on (.+)"
)
_SECRETS: Final = re.compile(r"(^|/)(alive(?:/(?:both|mind|body)(?=/))?)/.*")
"""What follows in a token is of one process only."""
_VERBS: Final = {
    "Put": "write", "Delete": "delete", "Query": "ask for", "Reply": "answer", "Declare Subscriber": "read",
    "Declare Queryable": "answer", "Declare Liveliness Token": "appear at", "Liveliness Token": "appear at",
    "Declare Liveliness Subscriber": "see", "Liveliness Query": "see",
}  # fmt: skip
_MOST_SESSIONS: Final = 10_000


class Denials:
    """Counts what was denied, and says so at the 1st, 10th, 100th time and so on."""

    def __init__(self) -> None:
        self._names: dict[bytes, str] = {}
        self._last: dict[bytes, bytes] = {}
        self._times: dict[str, Counter[str]] = {}

    def note(self, line: bytes) -> str:
        """Return in words what a line of Zenoh's log says that others must know; empty if nothing."""
        if not line.startswith(_LINE):
            return ""
        head, _, text = line.partition(_MESSAGE)
        start = head.find(b"ThreadId(")
        thread = head[start : head.find(b")", start)]
        if text.startswith(_DROPPED):
            return self._dropped(self._last.pop(thread, b""))
        if any(part in head for part in _ACCEPTS):
            why = next((words for said, words in _NOT_LET_IN.items() if said in text), "")
            return self._count(SOMEBODY, f"{SOMEBODY} {why}") if why else ""
        if (found := _REFUSES.match(text)) is not None and (named := _NAME.search(found[2])) is not None:
            if len(self._names) > _MOST_SESSIONS:
                self._names.clear()
            self._names[found[1]] = named[1].decode("utf-8", "replace")
        self._last[thread] = text
        return ""

    def skip(self) -> None:
        """Note that lines are missing here: what follows does not belong to what came before."""
        self._last.clear()

    def _dropped(self, why: bytes) -> str:
        found = _DENIED.match(why)
        verb = None if found is None else _VERBS.get(found[4].decode())
        if found is None or verb is None:
            return ""
        named = _NAME.search(found[2] or b"")
        who = self._names.get(found[1], SOMEBODY) if named is None else named[1].decode("utf-8", "replace")
        key = _SECRETS.sub(r"\1\2/*", found[5].decode("utf-8", "replace"))
        # What a rule allows is dropped only for its length.
        return self._count(who, sentence(who, verb, key[:100]) + ("" if found[3] else " at such length"))

    def _count(self, who: str, what: str) -> str:
        times = self._times.setdefault(who, Counter())
        if what not in times and len(times) >= MOST:
            what = f"{who} may not use other keys"
        times[what] += 1
        return f"denied why={what!r} times={times[what]}" if str(times[what]).rstrip("0") == "1" else ""
