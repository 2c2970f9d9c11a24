"""Names that are part of keys. A name is checked before it becomes part of a key, and when it is read from a key.

Zenoh itself accepts spaces, '*', newlines and a leading '@' in a chunk. The keys of an agent called '*' would match
those of all agents, and no wildcard would match those of '@x'.
"""

from __future__ import annotations

import re
import secrets
from typing import Final

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import HEX_PATTERN, NAME_PATTERN, WORD_PATTERN

EXPECTED: Final = "a name of a-z, 0-9, _ and -, a letter first, at most 32 characters"
RESERVED: Final = frozenset({"operator"})
"""Names that no agent may have; `operator` is the sender of messages from operators."""

_NAME = re.compile(NAME_PATTERN)
_WORD = re.compile(WORD_PATTERN)
_HEX = re.compile(HEX_PATTERN)


def check_name(text: str, where: str = "") -> str:
    """Return `text` if it is a valid name for keys.

    Args:
        text: Name of a world, an agent or a crew.
        where: What the name is for, as a text for the error.

    Raises:
        WireError: `value`, if it is invalid.
    """
    if _NAME.match(text) is None:
        raise WireError("value", f"{where}: expected {EXPECTED}, got {text[:40]!r}".removeprefix(": "), where)
    return text


def check_agent(text: str, where: str = "") -> str:
    """Return `text` if it is a valid name for an agent and not reserved.

    Raises:
        WireError: `value`, if it is not.
    """
    if check_name(text, where) in RESERVED:
        raise WireError(
            "value", f"{where}: expected a name that is not reserved, got {text!r}".removeprefix(": "), where
        )
    return text


def check_word(text: str, where: str = "") -> str:
    """Return `text` if it is a word, such as the name of a place.

    Raises:
        WireError: `value`, if it is not.
    """
    if _WORD.match(text) is None:
        expected = "a word of letters, digits, _, . and -, at most 64 characters"
        raise WireError("value", f"{where}: expected {expected}, got {text[:40]!r}".removeprefix(": "), where)
    return text


def is_name(text: str) -> bool:
    """Return whether `text` is a valid name."""
    return _NAME.match(text) is not None


def is_hex(text: str) -> bool:
    """Return whether `text` is 16 lower-case hex digits: an instance, run, session or hash."""
    return _HEX.match(text) is not None


def new_hex() -> str:
    """Return 16 random lower-case hex digits, for an instance, a run or a session."""
    return secrets.token_hex(8)
