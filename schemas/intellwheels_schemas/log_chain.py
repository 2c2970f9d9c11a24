"""The checksums of an input log: each line carries one over itself and all lines before it.

The last field of a line is `Chain`: BLAKE2b-64, as 16 hex digits, of the `Chain` of the line before (nothing for the
first line) followed by the bytes of this line up to `,"Chain"`. So a changed, removed or inserted byte is found at its
line. It is a checksum and no signature: who changes a log can also compute its chain again.
"""

from __future__ import annotations

import hashlib
import re
from typing import Final

_EMPTY: Final = b',"Chain":""}'
_FIELD: Final = re.compile(rb',"Chain":"([0-9a-f]{16})"}')
_LENGTH: Final = len(b',"Chain":"0123456789abcdef"}')


class Chain:
    """The checksum of a log up to a line.

    Attributes:
        value: 16 hex digits; empty before the first line.
    """

    def __init__(self) -> None:
        self.value = ""

    def seal(self, record: bytes) -> bytes:
        """Return the next line with its checksum.

        Args:
            record: A JSON object with at least one field; its last field may be an empty `Chain`.
        """
        covered = record.removesuffix(_EMPTY) if record.endswith(_EMPTY) else record[:-1]
        self.value = self._of(covered)
        return b'%b,"Chain":"%b"}' % (covered, self.value.encode())

    def check(self, line: bytes) -> str | None:
        """Take the next line, and return None, or what is wrong with its checksum.

        Args:
            line: The line without its newline.
        """
        found = _FIELD.fullmatch(line, max(0, len(line) - _LENGTH))
        expected = self._of(line[:-_LENGTH])
        if found is None:
            return f"expected checksum {expected} at its end, got none"
        got = found[1].decode()
        if got != expected:
            return f"expected checksum {expected}, got {got}"
        self.value = got
        return None

    def _of(self, covered: bytes) -> str:
        return hashlib.blake2b(self.value.encode() + covered, digest_size=8).hexdigest()


def unsealed(line: bytes) -> bytes:
    """Return a sealed line without its checksum."""
    return line[:-_LENGTH] + b"}"


def is_sealed(line: bytes) -> bool:
    """Return whether a line ends with a checksum, right or wrong."""
    return _FIELD.fullmatch(line, max(0, len(line) - _LENGTH)) is not None


def has_more_than_a_line(text: bytes) -> bool:
    """Return whether something other than a newline follows a checksum."""
    return any(found.end() < len(text) for found in _FIELD.finditer(text))
