"""The points about how a program puts its Actions. Each returns what it observed, or raises `PointError`."""

from __future__ import annotations

from intellwheels_experiments.conformance.agent_session import SAY_LIMIT, AgentSession, PointError, shown
from intellwheels_schemas.codec import Encoding, encoding_of
from intellwheels_schemas.errors import WireError


def names(session: AgentSession) -> str:
    """Answers: its Actions name the Tick, the Run and the Session, so that old ones are recognised."""
    session.require_joined()
    session.exchange()
    actions = session.read(session.last_put)
    missing = [wire for wire in ("Tick", "Run", "Session") if getattr(actions, wire.lower()) is None]
    if missing:
        raise PointError("Actions with Tick, Run and Session", f"no {', '.join(missing)}: {shown(session.last_answer)}")
    return "tick, run and session are named"


def encoding(session: AgentSession) -> str:
    """Answers: the encoding of its put is that of the bytes, application/json or application/xml."""
    session.require_joined()
    session.exchange()
    put = session.last_put
    expected = encoding_of("", put.data)
    try:
        # Without an encoding the simulator goes by the first byte. A program should not rely on it.
        right = put.encoding.startswith("application/") and encoding_of(put.encoding) is expected
    except WireError:
        right = False
    if not right:
        raise PointError(f"the encoding {expected} for {_noun(expected)}", put.encoding or "none")
    return put.encoding


def _noun(encoding: Encoding) -> str:
    return "JSON" if encoding is Encoding.JSON else "XML"


def congestion(session: AgentSession) -> str:
    """Answers: its put has the congestion control drop, so that one stuck reader does not stop the others."""
    session.require_joined()
    session.exchange()
    if session.last_put.blocks:
        raise PointError("the congestion control drop", "block")
    return "drop"


def say(session: AgentSession) -> str:
    """Hears a text of SayLimit characters: says at most SayLimit characters itself."""
    session.require_joined()
    for heard in ("", "x" * SAY_LIMIT, ""):
        session.exchange(heard=heard)
        said = session.read(session.last_put).say or ""
        if len(said) > SAY_LIMIT:
            raise PointError(f"a Say of at most {SAY_LIMIT} characters", f"{len(said)}: {shown(said.encode())}")
    return f"no Say is longer than {SAY_LIMIT} characters"
