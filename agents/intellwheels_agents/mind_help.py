"""The help of an included mind: what it does, and its options with ranges and defaults.

`iw-agent MIND --help` shows it. The ranges come from the mind itself: it is made once, and its
options note what it reads.
"""

from __future__ import annotations

import contextlib
from importlib import import_module

from intellwheels_agents import minds
from intellwheels_agents.mind_trial import check_mind_options
from intellwheels_agents.options import OptionError, Options
from intellwheels_agents.robot_document import default_robot
from intellwheels_maps import floor, robot
from intellwheels_schemas.errors import WireError

MAP = "ward"
"""Map that the mind is made on."""


def mind_help(name: str) -> str:
    """Return the help of an included mind."""
    about = (import_module(f"{minds.__name__}.{name}").__doc__ or "").strip()
    rows = option_rows(name)
    width = max(map(len, rows), default=0)
    listed = "".join(f"  {option:<{width}}  {text}\n" for option, text in rows.items()) or "  none\n"
    return (
        f"usage: iw-agent {name} [--option NAME=VALUE ...]\n\n{about}\n\n"
        f"ranges and defaults, as the mind reads them (--option NAME=VALUE):\n{listed}\n"
        "iw-agent --help lists the options of the command, such as --name, --robot and --connect.\n"
    )


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
