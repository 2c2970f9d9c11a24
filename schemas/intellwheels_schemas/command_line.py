"""The command line of a program in any language: its words, and what is replaced in them. Pure."""

from __future__ import annotations

import difflib
import re
import shlex
from collections.abc import Mapping, Sequence
from typing import Final

from intellwheels_schemas.errors import wrong_value

PLACEHOLDERS: Final = ("name", "endpoint", "world")
"""The words that are replaced where they stand in braces: the agent, where to connect, and the world."""

_PLACEHOLDER: Final = re.compile(r"\{([A-Za-z_]\w*)\}")


def words_of(line: str, where: str) -> list[str]:
    """Return the words of a command line, which has the quotes of a shell.

    Raises:
        WireError: There is no word, a quote is not closed, or a placeholder is unknown.
    """
    try:
        words = shlex.split(line)
    except ValueError as error:
        raise wrong_value(where, "a command line", f"{line!r} ({str(error).lower()})") from None
    if not words:
        raise wrong_value(where, "a command line", "no word")
    check_placeholders(words, where)
    return words


def check_placeholders(words: Sequence[str], where: str) -> None:
    """Check that only known words stand in braces. Other braces may be part of the line, as in JSON.

    Raises:
        WireError: One is unknown.
    """
    for name in (found for word in words for found in _PLACEHOLDER.findall(word)):
        if name not in PLACEHOLDERS:
            near = difflib.get_close_matches(name, PLACEHOLDERS, n=1)
            hint = f"; did you mean {{{near[0]}}}?" if near else ""
            known = ", ".join(f"{{{one}}}" for one in PLACEHOLDERS)
            raise wrong_value(where, f"the placeholders {known}", f"{{{name}}}{hint}")


def filled(word: str, values: Mapping[str, str]) -> str:
    """Return a word with each `{name}` replaced by its value. Other braces stay."""
    for name, value in values.items():
        word = word.replace(f"{{{name}}}", value)
    return word
