"""Asks the router of a lab what this session may do, so that a denial has words.

The router answers below `rights.RIGHTS`. The official `zenohd` does not; then the identity file says what was allowed
when it was written.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable
from typing import Any, Final

import zenoh

from intellwheels_schemas.codec import decode, encode, encoding_of
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_file import IdentityFile
from intellwheels_schemas.messages import Identity, Role
from intellwheels_schemas.rights import Does, denial, join_denial, rights_key, serve_denial

TIMEOUT: Final = 1.0
"""Seconds that the router has to answer."""

_opened: Final[dict[str, IdentityFile]] = {}
"""The identities of the sessions of this process, by their Zenoh id."""


class NotAllowedError(ConnectionError):
    """The router does not allow what was asked; the text says who may not do what."""


def remember(session: zenoh.Session, identity: IdentityFile) -> None:
    """Note with which identity a session was opened."""
    _opened[str(session.info.zid())] = identity


def own_rights(session: zenoh.Session, *, sure: bool = False) -> Identity | None:
    """Return what the identity of a session may do; None if it has none, or if nobody knows.

    It waits for the router, at most `TIMEOUT`.

    Args:
        session: The session.
        sure: Whether only the router's answer counts, and not the identity file, which may be out of date.
    """
    own = _opened.get(str(session.info.zid()))
    if own is None:
        return None
    answers: list[Identity] = []
    done = threading.Event()

    def on_reply(reply: zenoh.Reply) -> None:
        if (sample := reply.ok) is not None:
            data = sample.payload.to_bytes()
            try:
                answers.append(decode(Identity, data, encoding_of(str(sample.encoding), data), strict=False))
            except WireError:
                return  # of a newer router

    session.get(rights_key(own.name), zenoh.handlers.Callback(on_reply, done.set), timeout=TIMEOUT)
    done.wait(TIMEOUT + 0.5)
    if answers:
        return answers[0]
    return Identity(name=own.name, may=own.may) if own.may and not sure else None


def unanswered(session: zenoh.Session, key: str) -> ConnectionError:
    """Return the error of a query that nobody answered: a denial if it is one."""
    own = own_rights(session)
    if own is not None and (denied := denial(own, key)):
        return NotAllowedError(denied)
    # A router that does not say so may deny it all the same.
    knows = own is not None and own_rights(session, sure=True) is not None
    return ConnectionError(f"no simulator at {key}" if knows else f"no simulator at {key}, or not allowed")


def denied(session: zenoh.Session, key: str, does: Does, *, sure: bool = False) -> str:
    """Return in words that this session may not do something with a key; empty if it may, or if nobody knows."""
    own = own_rights(session, sure=sure)
    return "" if own is None else denial(own, key, does)


def denied_join(session: zenoh.Session, world: str, role: Role, agent: str, *, sure: bool = False) -> str:
    """Return in words that this session may not join as an agent; empty if it may, or if nobody knows."""
    own = own_rights(session, sure=sure)
    return "" if own is None else join_denial(own, world, role, agent)


def denied_service(session: zenoh.Session, world: str) -> str:
    """Return in words that this session may not be the simulator of a world; empty if it may, or if nobody knows."""
    own = own_rights(session, sure=True)
    return "" if own is None else serve_denial(own, world)


def answer_rights(session: zenoh.Session, identities: Iterable[Identity]) -> list[Any]:
    """Answer each identity what it may do, in a session that is a router. Return the queryables, to be kept."""

    def answering(identity: Identity) -> Any:
        key, data = rights_key(identity.name), encode(identity)

        def answer(query: zenoh.Query) -> None:
            with query:
                query.reply(key, data, encoding=zenoh.Encoding.APPLICATION_JSON)

        return session.declare_queryable(key, answer)

    return [answering(identity) for identity in identities]
