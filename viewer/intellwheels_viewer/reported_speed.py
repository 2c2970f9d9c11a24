"""Speeds of real bodies, for every panel and label alike. Pure, on one thread.

The poses of a real body come at the rate of its bridge: at one tick none is new, at another two are. The speed in the
state is that of one tick, so it jumps between nothing and twice the speed. Here it is the mean over `WINDOW`.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final

import msgspec

from intellwheels_schemas.messages import Entity

WINDOW: Final = 1.0
"""Simulated seconds of the mean (chosen): a pose that is one tick early or late then changes it by 5 % at 20 Hz."""

_Moved = tuple[float, float, float, float, float, float]
"""Time, x, y and heading of a state, and the distance and the angle that the body has moved up to it."""


class ReportedSpeeds:
    """The recent motion of real bodies, by agent."""

    def __init__(self) -> None:
        self._moved: dict[str, deque[_Moved]] = {}

    def clear(self) -> None:
        """Forget all motion: another run, or another position of a playback."""
        self._moved.clear()

    def smoothed(self, entity: Entity, time: float) -> Entity:
        """Return a real body's state with the mean speed and turn rate of the last `WINDOW` seconds.

        The first state of a body is returned as it is, and so is one after a gap.

        Args:
            entity: The body at this time.
            time: In simulated seconds, not before that of the last call for this body.
        """
        moved = self._moved.setdefault(entity.name, deque())
        if moved and time - moved[-1][0] > WINDOW:
            moved.clear()
        distance = angle = 0.0
        if moved:
            _, x, y, heading, distance, angle = moved[-1]
            turned = math.remainder(entity.heading - heading, math.tau)
            middle = heading + 0.5 * turned
            distance += (entity.x - x) * math.cos(middle) + (entity.y - y) * math.sin(middle)
            angle += turned
            if time <= moved[-1][0]:
                moved.pop()  # the same tick again, as after a change during a pause
        moved.append((time, entity.x, entity.y, entity.heading, distance, angle))
        while moved[0][0] < time - WINDOW - 1e-9:
            moved.popleft()
        span = time - moved[0][0]
        if span <= 0.0:
            return entity
        return msgspec.structs.replace(
            entity, speed=(distance - moved[0][4]) / span, turn_rate=(angle - moved[0][5]) / span
        )
