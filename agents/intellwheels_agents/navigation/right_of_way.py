"""How chairs that stand in each other's way agree who goes first, by messages.

A chair that makes no progress says its way, "way X Y X Y ...", in metres. Who hears it and stands on that way, or makes
no progress itself and has less right, drives off the way and waits there until it has not heard it for a while. A chair
that has arrived has the least right. Among others the names decide, the first in order has the most, so of any two one
gives way.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from intellwheels_agents.portable_math import dist
from intellwheels_schemas.messages import Heard

SAY_PERIOD: Final = 0.5
"""Time between two messages, s."""
FORGET: Final = 2.5
"""Time after which a way that is not said any more is free, s."""
SPACING: Final = 0.6
"""Distance between the points that are said, m."""
LENGTH: Final = 3.6
"""Length of the way that is said, m."""
ROOM: Final = 0.8
"""Distance between a way and the centre of a chair that has driven off it, m."""
_WAY: Final = re.compile(r"way((?: -?\d{1,4}\.\d -?\d{1,4}\.\d)+)")

Point = tuple[float, float]


def way_message(way: Sequence[Point], limit: int) -> str:
    """Return the message that says a way, in at most `limit` characters."""
    text, last = "way", None
    for x, y in way:
        if last is not None and dist((x, y), last) < SPACING:
            continue
        longer = f"{text} {x + 0.0:.1f} {y + 0.0:.1f}"
        if len(longer) > limit:
            break
        text, last = longer, (x, y)
    return text


def way_in(text: str) -> list[Point]:
    """Return the way that a message says; empty if it is another message."""
    found = _WAY.fullmatch(text)
    if found is None:
        return []
    numbers = [float(word) for word in found.group(1).split()]
    return list(zip(numbers[::2], numbers[1::2], strict=True))


class RightOfWay:
    """Whom one chair must let pass."""

    def __init__(self, name: str) -> None:
        """Take the name of the chair."""
        self._name = name
        self._heard: dict[str, tuple[float, list[Point]]] = {}

    def update(self, time: float, messages: Sequence[Heard]) -> None:
        """Take the messages of a tick."""
        for message in messages:
            way = way_in(message.text)
            if way:
                self._heard[message.sender] = time, way
        self._heard = {who: (at, way) for who, (at, way) in self._heard.items() if time - at <= FORGET}

    def to_clear(self, here: Point, stalled: bool, arrived: bool, room: float = ROOM) -> list[Point]:
        """Return the points of the ways that this chair must leave free; empty if none.

        Args:
            here: Where it is, m.
            stalled: Whether it makes no progress.
            arrived: Whether it has reached its goal.
            room: Distance from a way within which it is on the way, m.
        """
        found: list[Point] = []
        for who, (_, way) in self._heard.items():
            blocks = any(dist(here, point) < room for point in way)
            if blocks and (arrived or (stalled and who < self._name)):
                found += way
        return found
