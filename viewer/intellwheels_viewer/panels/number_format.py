"""Numbers as people read them: fixed decimals, a true minus, no negative zero. Units stand in captions only."""

from __future__ import annotations

import math
from typing import Final

from intellwheels_viewer.snapshot import Snapshot

MINUS: Final = "\u2212"


def decimal(value: float, places: int = 2) -> str:
    """Return a number with so many decimals, its minus as wide as a digit."""
    text = f"{value:.{places}f}"
    if not text.strip("-0."):
        return text.lstrip("-")
    return text.replace("-", MINUS)


def factor(value: float) -> str:
    """Return a factor without zeros that say nothing: 1, 0.5, 10."""
    return f"{value:g}"


def degrees(radians: float) -> str:
    """Return an angle in whole degrees."""
    return decimal(math.degrees(radians), 0)


def period(seen: Snapshot) -> float | None:
    """Return the simulated seconds of a tick, None before the first."""
    if seen.clock is not None and seen.clock.tick:
        return seen.clock.time / seen.clock.tick
    return seen.time / seen.tick if seen.tick else None


def moment(tick: int, seen: Snapshot) -> str:
    """Return the simulated seconds at a tick; before a tick's length is known, only tick 0 has a time."""
    length = period(seen)
    if length is None:
        return decimal(0.0) if tick == 0 else "?"
    return decimal(tick * length)
