"""The version of this installation, for `--version` of every command, logs and reports."""

from __future__ import annotations

import argparse
import platform
from importlib.metadata import PackageNotFoundError, version
from typing import Final

DISTRIBUTION: Final = "intellwheels"

UNKNOWN: Final = "unknown"
"""The version of what is not installed."""


def installed_version(distribution: str = DISTRIBUTION) -> str:
    """Return the version of an installed distribution, or `UNKNOWN`, as in a checkout that was not installed."""
    try:
        return version(distribution)
    except PackageNotFoundError:
        return UNKNOWN


def versions_of(*distributions: str) -> dict[str, str]:
    """Return the version of Python and of each distribution, by name; `UNKNOWN` for those that are not installed."""
    return {"python": platform.python_version(), **{name: installed_version(name) for name in distributions}}


def version_text() -> str:
    """Return the text of `--version`: the product, its version, and the version of the Zenoh library."""
    return f"intellwheels {installed_version()} (eclipse-zenoh {installed_version('eclipse-zenoh')})"


def add_version_option(parser: argparse.ArgumentParser) -> None:
    """Add `--version`, which every command has: `process.add_process_options` calls this."""
    parser.add_argument("--version", action="version", version=version_text(), help="print the version, and exit")
