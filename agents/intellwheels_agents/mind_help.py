"""The help of an included mind: what it does, and its options with ranges and defaults.

`iw-agent MIND --help` shows it. The words come from the mind's docstring. The ranges and defaults come from the mind
itself: it is made once, and its options note what it reads.
"""

from __future__ import annotations

import contextlib
import re
import textwrap
from collections.abc import Mapping
from importlib import import_module
from typing import Final

from intellwheels_agents import minds
from intellwheels_agents.mind_trial import check_mind_options
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.robot_document import default_robot
from intellwheels_maps import floor, robot
from intellwheels_schemas.errors import WireError

MAP = "ward"
"""Map that the mind is made on."""
WIDTH: Final = 120
"""Longest line of the list of options."""
_BLOCK: Final = re.compile(r"^(?: {4,}\S.*\n?)+", re.MULTILINE)
"""The first indented lines of a docstring: the options."""
_ENTRY: Final = re.compile(r"^ {4}(\w+(?:, \w+)*) +(\S.*(?:\n {5,}\S.*)*)", re.MULTILINE)
"""An option of them, or several, and its text."""
_DEFAULT: Final = re.compile(r" \((?:default [^()]*|required)\)$")


def mind_help(name: str) -> str:
    """Return the help of an included mind."""
    about = (import_module(f"{minds.__name__}.{name}").__doc__ or "").strip()
    block = _BLOCK.search(about)
    before, _, after = (about, "", "") if block is None else about.partition(block[0])
    listed = "  none" if block is None else _list(block[0], option_rows(name))
    parts = (
        f"usage: iw-agent {name} [--option NAME=VALUE ...]",
        before.strip(),
        f"options (--option NAME=VALUE):\n{listed}",
        after.strip(),
        "iw-agent --help lists the options of the command, such as --name, --robot and --connect.",
    )
    return "\n\n".join(filter(None, parts)) + "\n"


def _list(block: str, rows: Mapping[str, str]) -> str:
    """Return the options that a docstring describes, each with the range and default that the mind reads."""
    entries = _ENTRY.findall(block)
    width = max(len(names) for names, _ in entries)
    lines: list[str] = []
    for names, words in entries:
        # The range has the default too.
        text = _DEFAULT.sub("", " ".join(words.split()))
        ranges = dict.fromkeys(rows[option] for option in names.split(", "))
        lines += textwrap.wrap(
            f"{text} ({' / '.join(ranges)})",
            WIDTH,
            initial_indent=f"  {names:<{width}}  ",
            subsequent_indent=" " * (width + 4),
        )
    return "\n".join(lines)


def option_rows(name: str) -> dict[str, str]:
    """Return the range and default of each option that an included mind reads, by name."""
    source = minds.find(name)
    document = floor(MAP)
    places = document.grid.position if document.grid else ()
    first = places[0].name if places else ""
    rows: dict[str, str] = {}
    # Some minds need to know where to go before they read further options.
    for given in ({}, {"to": first}):
        read = Options(given)
        with contextlib.suppress(OptionError, WireError):
            body = source.equip(robot(default_robot(name)), read)
            rows |= read.declared
            check_mind_options(source, body, given, fetch_map=lambda: document, read=read)
        rows |= read.declared
    return rows
