"""The options that name a CAN bus: those of `iw-bridge rnet` and of its stand-in."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any, Final

from intellwheels_schemas.errors import WireError

INTERFACE: Final = "socketcan"
RESERVED: Final = ("interface", "channel", "bitrate", "can_filters", "receive_own_messages", "fd", "listen_only")
"""Options of python-can that the driver sets itself, or that its safety depends on."""


def add_bus_options(group: argparse._ActionsContainer) -> None:
    """Add `--channel`, `--interface` and `--can-option`."""
    group.add_argument("--channel", metavar="BUS", help="CAN bus such as can0, set to 125 kbit/s; required")
    group.add_argument(
        "--interface", default=INTERFACE, metavar="NAME",
        help=f"kind of CAN adapter, as python-can names it (default: {INTERFACE})",
    )  # fmt: skip
    group.add_argument(
        "--can-option", action="append", default=[], metavar="KEY=VALUE",
        help="another option of python-can for this kind of adapter; may be repeated",
    )  # fmt: skip


def check_bus(interface: str, channel: str) -> None:
    """Check `--interface` and `--channel`. The bus need not exist yet.

    Raises:
        WireError: python-can does not know the kind of adapter, or the bus has no name.
    """
    from can import VALID_INTERFACES  # noqa: PLC0415 - an optional dependency, which agents do not need

    if interface not in VALID_INTERFACES:
        known = ", ".join(sorted(VALID_INTERFACES))
        raise WireError("value", f"--interface: expected one of {known}, got {interface[:100]!r}", "--interface")
    if not channel:
        raise WireError("value", "--channel: expected a CAN bus such as can0, got ''", "--channel")


def bus_options(given: Sequence[str]) -> dict[str, Any]:
    """Return what `--can-option` gives: whole numbers as such, all else as text.

    Raises:
        WireError: One has not this form, is given twice, or is set by the driver itself.
    """
    options: dict[str, Any] = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not equals or not name.isidentifier() or name in options or name in RESERVED:
            expected = f"KEY=VALUE, each key once and none of {', '.join(RESERVED)}"
            raise WireError("value", f"--can-option: expected {expected}, got {text[:100]!r}", "--can-option")
        options[name] = int(value) if value.isascii() and value.isdigit() and len(value) < 12 else value
    return options
