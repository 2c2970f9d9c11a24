"""Reads ordinary `Actions` fast: those of most agents in most ticks, with numbers only.

Whatever is not sure to be right here is left to the codec, which finds the error.
"""

from __future__ import annotations

import re
from typing import Final

import msgspec

from intellwheels_schemas.messages import Actions, Power, SentSeq, SentTick

REMEMBERED: Final = 8_192
"""Runs and sessions that are remembered: anyone can invent them."""
_MAX_INTEGER: Final = 2**53 - 1

_ID: Final = "([0-9a-f]{16})"
_INTEGER: Final = "(0|[1-9][0-9]{0,15})"
_NUMBER: Final = r"(-?(?:0|[1-9][0-9]*)(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?)"
# As the writer of this project writes it; other programs may write attributes in another order.
_XML: Final = re.compile(
    f'<Actions(?: Run="{_ID}")? Session="{_ID}"(?: Tick="{_INTEGER}")?(?: Seq="{_INTEGER}")?'
    f'(?: LeftMotor="{_NUMBER}")?(?: RightMotor="{_NUMBER}")? ?/>'
)


class _Drive(msgspec.Struct, rename="pascal", forbid_unknown_fields=True, frozen=True):
    """`Actions` with numbers only. A pattern costs more than all the rest, so runs and sessions are texts."""

    run: str
    session: str
    tick: SentTick | None = None
    seq: SentSeq | None = None
    left_motor: Power | None = None
    right_motor: Power | None = None


_read: Final = msgspec.json.Decoder(_Drive).decode
_known: set[str] = set()


def remember(actions: Actions) -> None:
    """Remember the run and the session of actions that the codec has checked."""
    if actions.run is not None and actions.session is not None:
        if len(_known) >= REMEMBERED:
            _known.clear()
        _known.update((actions.run, actions.session))


def from_json(data: bytes) -> Actions | None:
    """Return the actions in a JSON document, or None if the codec must read it.

    Their run and session must be remembered.
    """
    try:
        drive = _read(data)
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return None
    run, session, tick, seq = drive.run, drive.session, drive.tick, drive.seq
    left, right = drive.left_motor, drive.right_motor
    # Each value that was read has one colon, as no name or text of it has one. More are repeated names, or nulls.
    fields = 6 - (tick is None) - (seq is None) - (left is None) - (right is None)
    if run not in _known or session not in _known or data.count(b":") != fields:
        return None
    return Actions(run=run, session=session, tick=tick, seq=seq, left_motor=left, right_motor=right)


def from_xml(data: bytes) -> Actions | None:
    """Return the actions in an XML document, or None if the codec must read it."""
    try:
        found = _XML.fullmatch(data.decode("ascii"))
    except UnicodeDecodeError:
        return None
    if found is None:
        return None
    run, session, tick_text, seq_text, left_text, right_text = found.groups()
    tick, seq = None if tick_text is None else int(tick_text), None if seq_text is None else int(seq_text)
    left, right = None if left_text is None else float(left_text), None if right_text is None else float(right_text)
    if (tick or 0) > _MAX_INTEGER or (seq or 0) > _MAX_INTEGER or not -1.0 <= (left or 0.0) <= 1.0:
        return None
    if not -1.0 <= (right or 0.0) <= 1.0:
        return None
    return Actions(run=run, session=session, tick=tick, seq=seq, left_motor=left, right_motor=right)
