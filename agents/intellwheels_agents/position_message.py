"""The message with which an agent says where it is: "at X Y", metres in the map frame."""

from __future__ import annotations

import re

from intellwheels_agents.pure_pursuit import Point

_NUMBER = r"(-?\d{1,5}(?:\.\d{1,9})?)"
_POSITION = re.compile(rf"at {_NUMBER} {_NUMBER}")


def position_message(x: float, y: float, decimals: int) -> str:
    """Return the message for a position, m, rounded to so many decimals."""
    return f"at {x:.{decimals}f} {y:.{decimals}f}"


def position_in(text: str) -> Point | None:
    """Return the position (m) that a message states, or None if it is another message."""
    found = _POSITION.fullmatch(text)
    return (float(found.group(1)), float(found.group(2))) if found else None
