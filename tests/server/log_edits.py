"""Changes logs: as somebody who edits the file, and as somebody who also makes its checksums again."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from intellwheels_schemas.log_chain import Chain, unsealed


def records(path: Path) -> list[bytes]:
    """Return the lines of a log, without its end, their checksums and newlines."""
    return [unsealed(line) for line in path.read_bytes().splitlines() if not line.startswith(b'{"End":')]


def rewrite(path: Path, lines: Sequence[bytes]) -> None:
    """Write a whole log with these lines, and with checksums that are right."""
    chain, end = Chain(), b'{"End":"closed","Lines":%d}' % len(lines)
    path.write_bytes(b"".join(chain.seal(line) + b"\n" for line in [*lines, end]))


def make_version_1(path: Path) -> None:
    """Make a log one of version 1, without checksums and end."""
    first, *rest = records(path)
    first = re.sub(rb'"Version":2', b'"Version":1', first, count=1)
    path.write_bytes(b"".join(line + b"\n" for line in [first, *rest]))
