"""The option `--identity`, which all commands that connect share."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from intellwheels_schemas.command_parser import readable_file
from intellwheels_schemas.errors import WireError
from intellwheels_schemas.identity_file import check_identity, read_identity


def add_identity_option(group: argparse._ActionsContainer) -> None:
    """Add the option with which a command shows who it is."""
    group.add_argument(
        "--identity", type=readable_file, metavar="FILE",
        help="who you are to the router of a lab: the file from iw-lab invite",
    )  # fmt: skip


def router_of(identity: Path | None) -> tuple[str, ...]:
    """Return the endpoints that an identity file names; none without a file.

    Raises:
        WireError: The file is none.
    """
    return () if identity is None else read_identity(identity).connect


def check_option(identity: Path) -> None:
    """Check the identity, and warn on standard error if it ends soon, or if others can read it.

    Raises:
        WireError: The file is none, or the identity has expired; the text names the option.
    """
    try:
        warning = check_identity(identity)
    except WireError as error:
        raise WireError(error.code, f"--identity: {error.text}", "--identity") from None
    if warning:
        sys.stderr.write(f"warning: {warning}\n")
