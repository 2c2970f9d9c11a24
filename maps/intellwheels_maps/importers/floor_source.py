"""What an importer gets and what it returns. Pure: only `library` reads files.

A place in a file is written like `levels.L1.walls[3]` or `line 12`, after the name of the file.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

from intellwheels_schemas.errors import WireError
from intellwheels_schemas.messages import ErrorCode, Map

MAX_SOURCE_BYTES: Final = 64 << 20
"""Longest file that is imported, 64 MiB."""


class FloorSource(NamedTuple):
    """A file to import.

    Attributes:
        name: Its path, as errors name it.
        data: Its bytes.
        beside: Returns the bytes of another file, whose path starts from the folder of this one, or raises a
            `WireError`.
        level: The level or storey to import; None takes the lowest.
    """

    name: str
    data: bytes
    beside: Callable[[str], bytes]
    level: str | None = None

    def error(self, place: str, text: str, code: ErrorCode = "value") -> WireError:
        """Return an error about a place in this file; the place may be empty."""
        where = f"{self.name}: {place}" if place else self.name
        return WireError(code, f"{where}: {text}", where)


class Imported(NamedTuple):
    """A map, and what the file has beyond it.

    Attributes:
        map: The map.
        left_out: A line for each reason for which the map does not have something: why, how much, and where.
        things: How many things that is. A region of cells counts as one.
    """

    map: Map
    left_out: tuple[str, ...] = ()
    things: int = 0


def chosen_level(source: FloorSource, known: list[str]) -> str:
    """Return the level of a building to import: the wanted one, or the first of those known.

    Raises:
        WireError: There is none, or not the wanted one.
    """
    if not known:
        raise source.error("", "expected at least one level, got none")
    if source.level is None:
        return known[0]
    if source.level not in known:
        raise source.error("", f"expected one of the levels ({', '.join(known)}) after '#', got {source.level!r}")
    return source.level


def check_no_level(source: FloorSource) -> None:
    """Check that no level of a file without levels is wanted.

    Raises:
        WireError: One is.
    """
    if source.level is not None:
        raise source.error(
            "", f"expected no '#' after the name, because this format has no levels, got {source.level!r}"
        )
