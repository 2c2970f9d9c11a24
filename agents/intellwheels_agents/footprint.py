"""Where a body goes when it moves, and what it would touch there. In the body's own frame, now.

What was seen is points. A body that already is nearer to a point than it should be may still move away from it: no
answer here ever locks a chair in.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from intellwheels_agents.pure_pursuit import Point
from intellwheels_agents.range_scan import Outline

Moving = tuple[float, float, float, float]

STEP = 0.03
"""Metres that the farthest corner moves between two looks: less than any margin that is worth keeping."""
AWAY = 1e-6
"""Metres of coming nearer that are rounding."""


class Footprint:
    """The rectangle a body covers.

    Attributes:
        radius: Metres from the centre of movement to the farthest corner.
    """

    def __init__(self, outline: Outline) -> None:
        """Take the outline; the rectangle is symmetric across."""
        self._front, self._back, self._side = outline.front, outline.back, outline.side
        self.radius = math.hypot(max(outline.front, outline.back), outline.side)

    def clearance(self, x: float, y: float) -> float:
        """Return metres from the rectangle to a point, negative inside."""
        dx, dy = max(x - self._front, -self._back - x), abs(y) - self._side
        if dx > 0.0 and dy > 0.0:
            return math.hypot(dx, dy)
        return max(dx, dy)

    def free(self, points: Iterable[Point], speed: float, turn_rate: float, seconds: float, margin: float) -> float:
        """Return for how many seconds the body can move on before it comes nearer than the margin to a point.

        Args:
            points: Of things that stand, m.
            speed: Forward, m/s, may be negative.
            turn_rate: Anticlockwise, rad/s.
            seconds: How far it is looked.
            margin: m.
        """
        return self.free_of_moving(((x, y, 0.0, 0.0) for x, y in points), speed, turn_rate, seconds, margin)

    def free_of_moving(
        self, points: Iterable[Moving], speed: float, turn_rate: float, seconds: float, margin: float
    ) -> float:
        """Return the same among points that move on as they do: x, y in m, and how fast in m/s."""
        own = abs(speed) + abs(turn_rate) * self.radius
        free = seconds
        for x, y, vx, vy in points:
            fastest = own + math.hypot(vx, vy)
            reach = self.radius + fastest * free + margin
            if fastest * free < AWAY or x * x + y * y > reach * reach:
                continue
            # A point is let in as far as it is already: what is too near may stay so, and go.
            clearance = self.clearance(x, y)
            least = min(margin, clearance) - AWAY
            time = 0.0
            while True:
                # Nothing comes nearer faster than `fastest`, so far points are looked at seldom.
                sure = min(time + max(clearance - least, 0.0) / fastest, free)
                time = min(time + max(clearance - least, STEP) / fastest, free)
                turn = turn_rate * time
                moved_x, moved_y = displacement(speed * time, turn)
                c, s = math.cos(turn), math.sin(turn)
                dx, dy = x + vx * time - moved_x, y + vy * time - moved_y
                clearance = self.clearance(c * dx + s * dy, c * dy - s * dx)
                if clearance < least:
                    free = sure
                    break
                if time == free:
                    break
        return free


def displacement(travel: float, turn: float) -> Point:
    """Return where an arc of so many metres and radians ends."""
    half = turn / 2.0
    chord = travel * (math.sin(half) / half if abs(half) > 1e-6 else 1.0)
    return chord * math.cos(half), chord * math.sin(half)
