"""The colour of a body: a fixed function of its name, the same in every viewer, playback and report. Pure.

Agents have twelve colours: six of Okabe and Ito ("Color Universal Design", 2008) and six between them. In any colour
vision two of them differ by 16 or more (CIE76), and in the common one by 26 or more. Stripes distinguish agents of the
same colour. Colours are three bytes of sRGB.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterable, Mapping
from typing import Final, NamedTuple, TypeAlias

RGB: TypeAlias = tuple[int, int, int]

COLOURS: Final[tuple[RGB, ...]] = (
    (0, 158, 115),
    (30, 30, 34),
    (119, 17, 255),
    (0, 114, 178),
    (136, 102, 68),
    (230, 159, 0),
    (86, 180, 233),
    (17, 85, 68),
    (153, 170, 85),
    (204, 121, 167),
    (0, 34, 136),
    (136, 0, 17),
)
"""Green, black, violet, blue, brown, orange, sky blue, dark green, olive, pink, navy, maroon. Neighbours differ."""

_START: Final = 974
"""The start of the CRC-32, chosen so that the names of each scene of the package have different colours."""

STRIPES: Final = 3
"""The largest number of stripes that people can distinguish at a glance."""

FIXTURES: Final[Mapping[str, RGB]] = {"door": (166, 112, 66), "table": (205, 172, 128)}
"""Colours of bodies that do not drive by themselves, by kind."""

THING: Final[RGB] = (176, 146, 108)
"""The colour of all other bodies that do not drive by themselves."""

_PARTS: Final = re.compile(r"\d+|\D+")
_LAST_NUMBER: Final = re.compile(r"(.*?)(\d*)")


class Look(NamedTuple):
    """The look of an agent: its colour, and its number of stripes from 0 to `STRIPES`."""

    colour: RGB
    stripes: int


def natural_key(name: str) -> tuple[tuple[int, int, str, str], ...]:
    """Return a sort key that puts `chair2` before `chair10`."""
    # Numbers are compared by length and digits: converting a long one would be slow.
    return tuple(_part_key(part) for part in _PARTS.findall(name))


def _part_key(part: str) -> tuple[int, int, str, str]:
    if not part.isdecimal():
        return 1, 0, part, ""
    digits = part.lstrip("0")
    return 0, len(digits), digits, part


def look_of(name: str) -> Look:
    """Return the look of a name, without regard to other names.

    Names that differ only in their last number get consecutive colours, and one more stripe after every twelve. The
    first colour follows from the rest of the name by its CRC-32.
    """
    match = _LAST_NUMBER.fullmatch(name)
    stem, digits = match.groups() if match else (name, "")
    # A name comes from a peer, but its length is bounded, so the conversion of a number is cheap.
    number = max(int(digits[-9:] or 1) - 1, 0)
    colour = (zlib.crc32(stem.encode(), _START) + number) % len(COLOURS)
    return Look(COLOURS[colour], number // len(COLOURS) % (STRIPES + 1))


def colour_of(name: str) -> RGB:
    """Return the colour of an agent. It depends only on the name."""
    return look_of(name).colour


def looks(names: Iterable[str]) -> dict[str, Look]:
    """Return the looks of the agents of one run, in natural order of their names.

    Each has the colour of its name. If two would look the same, the later one in natural order gets the next free
    number of stripes; with more than four agents of one colour looks repeat. The result does not depend on the order of
    names.
    """
    found: dict[str, Look] = {}
    used: set[Look] = set()
    for name in sorted(set(names), key=natural_key):
        own = look_of(name)
        options = [Look(own.colour, (own.stripes + more) % (STRIPES + 1)) for more in range(STRIPES + 1)]
        found[name] = next((option for option in options if option not in used), own)
        used.add(found[name])
    return found


def css(colour: RGB) -> str:
    """Return a colour as CSS and matplotlib write it: `#rrggbb`."""
    return "#{:02x}{:02x}{:02x}".format(*colour)
