"""The version of this installation, for `--version`, logs and reports."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from typing import Final

DISTRIBUTION: Final = "intellwheels"


def installed_version(distribution: str = DISTRIBUTION) -> str:
    """Return the version of an installed distribution, or `unknown` in a checkout that was not installed."""
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "unknown"


def version_text() -> str:
    """Return the text of `--version`: the product, its version, and the version of the Zenoh library."""
    return f"intellwheels {installed_version()} (eclipse-zenoh {installed_version('eclipse-zenoh')})"
