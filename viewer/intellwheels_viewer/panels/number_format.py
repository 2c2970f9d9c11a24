"""Formats numbers: fixed decimals, a real minus sign, no negative zero. Units are in captions."""

from __future__ import annotations

import math
from typing import Final

from intellwheels_viewer.snapshot import Snapshot

MINUS: Final = "\u2212"


def decimal(value: float, places: int = 2) -> str:
    """Return a number with this many decimals and a minus sign as wide as a digit."""
    text = f"{value:.{places}f}"
    if not text.strip("-0."):
        return text.lstrip("-")
    return text.replace("-", MINUS)


def factor(value: float) -> str:
    """Return a factor without trailing zeros: 1, 0.5, 10."""
    return f"{value:g}"


def degrees(radians: float) -> str:
    """Return an angle in whole degrees."""
    return decimal(math.degrees(radians), 0)


def moment(tick: int, snapshot: Snapshot) -> str:
    """Return the simulated time of a tick in seconds; `?` while the period is unknown, except for tick 0."""
    length = snapshot.period
    if length is None:
        return decimal(0.0) if tick == 0 else "?"
    return decimal(tick * length)
