"""The rectangle that a body covers, and for how long it can move before it comes too near to a point.

All coordinates are in the body's present frame. Obstacles are points. A body that is already nearer to a point than
the margin may still move away from it, so a chair is never locked in.
"""

# ruff: noqa: FURB136, PLR1730 - calls of `min` and `max` would cost more than the rest of a check.

from __future__ import annotations

from collections.abc import Iterable
from math import sqrt

from intellwheels_agents.portable_math import hypot, sincos
from intellwheels_agents.pure_pursuit import Point
from intellwheels_agents.range_scan import Outline

MovingPoint = tuple[float, float, float, float]
"""x and y (m), and their velocities (m/s)."""

STEP = 0.03
"""Metres that the farthest corner moves between two checks: less than any useful margin."""
ROUNDING = 1e-6
"""Metres of approach that count as a rounding error."""


class Footprint:
    """The rectangle a body covers.

    Attributes:
        radius: Metres from the centre of movement to the farthest corner.
    """

    def __init__(self, outline: Outline) -> None:
        """Take the outline; the rectangle is symmetric to the x axis."""
        self._front, self._back, self._side = outline.front, outline.back, outline.side
        self.radius = hypot(max(outline.front, outline.back), outline.side)

    def clearance(self, x: float, y: float) -> float:
        """Return the distance from the rectangle to a point in m, negative inside."""
        dx, dy = max(x - self._front, -self._back - x), abs(y) - self._side
        if dx > 0.0 and dy > 0.0:
            return hypot(dx, dy)
        return max(dx, dy)

    def free(self, points: Iterable[Point], speed: float, turn_rate: float, seconds: float, margin: float) -> float:
        """Return for how long the body can keep moving before a point comes nearer than the margin, in s.

        Args:
            points: Points that stand still, m.
            speed: Forward, m/s, may be negative.
            turn_rate: Anticlockwise, rad/s.
            seconds: How far to look ahead; the most that is returned.
            margin: The clearance to keep, m.
        """
        return self.free_of_moving(((x, y, 0.0, 0.0) for x, y in points), speed, turn_rate, seconds, margin)

    def free_of_moving(
        self, points: Iterable[MovingPoint], speed: float, turn_rate: float, seconds: float, margin: float,
        enough: float = 0.0,
    ) -> float:  # fmt: skip
        """Return the same as `free` among points that keep their velocities.

        A time below `enough` seconds need not be the shortest: the search ends with the first one.
        """
        own = abs(speed) + abs(turn_rate) * self.radius
        front, back, side, radius = self._front, self._back, self._side, self.radius
        free = seconds
        moved_at, moved_x, moved_y, s, c = 0.0, 0.0, 0.0, 0.0, 1.0
        for x, y, vx, vy in points:
            fastest = own + sqrt(vx * vx + vy * vy)
            way = fastest * free
            reach = radius + way + margin
            if way < ROUNDING or x * x + y * y > reach * reach:
                continue
            # A point that is already nearer than the margin may stay as near as it is.
            clearance = self.clearance(x, y)
            least = min(margin, clearance) - ROUNDING
            # Nor can a point come too near that is farther than all of the way.
            if clearance - least > way + ROUNDING:
                continue
            time = 0.0
            while True:
                # No point approaches faster than `fastest`, so a far point needs few checks.
                spare, before = clearance - least, time
                time += (spare if spare > STEP else STEP) / fastest
                if time > free:
                    time = free
                # `clearance`, inlined: a walker among others spends most of its time here.
                if turn_rate == 0.0:
                    along, across = x + vx * time - speed * time, abs(y + vy * time) - side
                else:
                    # Most points are checked at the end of the way.
                    if time != moved_at:
                        turn, moved_at = turn_rate * time, time
                        moved_x, moved_y = displacement(speed * time, turn)
                        s, c = sincos(turn)
                    dx, dy = x + vx * time - moved_x, y + vy * time - moved_y
                    along, across = c * dx + s * dy, abs(c * dy - s * dx) - side
                behind = -back - along
                along -= front
                if behind > along:
                    along = behind
                if along > 0.0 and across > 0.0:
                    clearance = sqrt(along * along + across * across)
                else:
                    clearance = along if along > across else across
                if clearance < least:
                    free = min(before + max(spare, 0.0) / fastest, free)
                    if free < enough:
                        return free
                    break
                if time == free or clearance - least > fastest * (free - time) + ROUNDING:
                    break
        return free


def displacement(travel: float, turn: float) -> Point:
    """Return the end of an arc from the origin along x, in m: `travel` is its length (m), `turn` its angle (rad)."""
    half = turn / 2.0
    s, c = sincos(half)
    chord = travel * (s / half if abs(half) > 1e-6 else 1.0)
    return chord * c, chord * s
