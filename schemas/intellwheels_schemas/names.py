"""Names that stand in keys. A name is checked before a key is made of it or it is believed.

Zenoh itself takes spaces, '*', newlines and a leading '@' in a chunk. An agent called '*' would
speak for everybody, and '@x' hides from every wildcard.
"""

from __future__ import annotations

import re
import secrets
from typing import Final

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import HEX_PATTERN, NAME_PATTERN

EXPECTED: Final = "a name of a-z, 0-9, _ and -, a letter first, at most 32 characters"
RESERVED: Final = frozenset({"operator"})
"""Names no agent may have: who speaks as one of them is not a body."""

_NAME = re.compile(NAME_PATTERN)
_HEX = re.compile(HEX_PATTERN)


def check_name(text: str, where: str = "") -> str:
    """Return `text` when it is a name, to be used in keys.

    Args:
        text: A world's, an agent's or a crew's name.
        where: What the name is for, named by the error.

    Raises:
        WireError: `value`, when it is not.
    """
    if _NAME.match(text) is None:
        raise WireError("value", f"{where}: expected {EXPECTED}, got {text[:40]!r}".removeprefix(": "), where)
    return text


def check_agent(text: str, where: str = "") -> str:
    """Return `text` when an agent may be called so: a name that is not reserved.

    Raises:
        WireError: `value`, when it is not.
    """
    if check_name(text, where) in RESERVED:
        raise WireError("value", f"{where}: expected a name not reserved, got {text!r}".removeprefix(": "), where)
    return text


def is_name(text: str) -> bool:
    """Return whether `text` is a name."""
    return _NAME.match(text) is not None


def is_hex(text: str) -> bool:
    """Return whether `text` is 16 lower-case hex digits: an instance, run, session or hash."""
    return _HEX.match(text) is not None


def new_hex() -> str:
    """Return 16 random lower-case hex digits, for an instance, a run or a session."""
    return secrets.token_hex(8)
