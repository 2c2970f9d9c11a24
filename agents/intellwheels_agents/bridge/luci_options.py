"""The options of `iw-bridge luci`."""

from __future__ import annotations

import argparse
import re
from typing import Final

from intellwheels_agents.bridge.luci_readings import STICK, WHEELS
from intellwheels_schemas.errors import WireError

PORT: Final = 50051
"""Port of the service, unless `--address` names another one: that of the maker's own client."""
_ADDRESS: Final = re.compile(r"([A-Za-z0-9][A-Za-z0-9.-]{0,252}|\[[0-9A-Fa-f:.%]{2,60}\])(?::([0-9]{1,5}))?")


def add_luci_options(result: argparse.ArgumentParser) -> None:
    """Add the options of the driver."""
    luci = result.add_argument_group("driver luci")
    luci.add_argument(
        "--address", metavar="HOST[:PORT]",
        help=f"network address of the LUCI unit; required (default port: {PORT})",
    )  # fmt: skip
    luci.add_argument(
        "--joystick-centre", type=int, choices=(0, STICK), default=STICK,
        help=f"value on the wire of a joystick at rest; the maker's client sends {STICK} (default: {STICK})",
    )  # fmt: skip
    luci.add_argument(
        "--reversed-encoder", action="append", choices=WHEELS, default=[],
        help="a wheel whose encoder counts down when the chair drives forward; may be repeated",
    )  # fmt: skip


def listen_address(text: str) -> str:
    """Return the address at which a stand-in listens: the type of its `--listen`. Port 0 is a free one."""
    form = _ADDRESS.fullmatch(text)
    if form is None or form[2] is None or int(form[2]) > 65535:
        raise argparse.ArgumentTypeError(f"expected HOST:PORT, got {text[:100]!r}")
    return text


def luci_address(text: str) -> str:
    """Return an address with its port.

    Raises:
        WireError: It has not the form HOST or HOST:PORT.
    """
    form = _ADDRESS.fullmatch(text)
    port = PORT if form is None or form[2] is None else int(form[2])
    if form is None or not 0 < port <= 65535:
        raise WireError("value", f"--address: expected HOST or HOST:PORT, got {text[:100]!r}", "--address")
    return f"{form[1]}:{port}"
