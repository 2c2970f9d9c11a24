"""Projects a body's footprint along its motion, and says whether it comes too near to an obstacle.

The wheel speeds lag behind their command, s' = a s + (1 - a) s* with a the `AccelerationCurve` (equation (1) of the
IntellWheels simulator paper), and the body follows the arcs that the wheels roll. A motion is free if no obstacle
point comes nearer than its own limit.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from intellwheels_agents.footprint import STEP
from intellwheels_agents.portable_math import hypot, sincos
from intellwheels_agents.pure_pursuit import Point
from intellwheels_agents.range_scan import Outline

CLEARANCE_SHARE: Final = 0.1
"""Where the clearance is already below the margin, a motion may use up this share of it. A chair that rests beside a
wall can then drive along it, and never touches it."""

WatchedPoint = tuple[float, float, float, float, float]
"""How far the body can move before the point can come too near (m), x and y of the point, and its least clearances (m):
to the footprint, and to the lengthened footprint."""


@dataclass(frozen=True, slots=True)
class Wheels:
    """Speeds of the wheels, m/s."""

    left: float
    right: float

    def lagged(self, wanted: Wheels, inertia: float) -> Wheels:
        """Return the speeds one tick later; `inertia` is the share of the old speed that remains."""
        return Wheels(
            inertia * self.left + (1.0 - inertia) * wanted.left, inertia * self.right + (1.0 - inertia) * wanted.right
        )


@dataclass(frozen=True, slots=True)
class MotionProjection:
    """Projects the motion of one body, from its outline, track (m), inertia and the simulation's period (s)."""

    outline: Outline
    track: float
    inertia: float
    period: float

    def clearance(self, x: float, y: float, swing: float) -> float:
        """Return the distance from the footprint to a point in m, negative inside; `swing` lengthens both ends."""
        body = self.outline
        middle, half = (body.front - body.back) / 2.0, (body.front + body.back) / 2.0 + swing
        dx, dy = abs(x - middle) - half, abs(y) - body.side
        if dx <= 0.0 or dy <= 0.0:
            return max(dx, dy)
        return hypot(dx, dy)

    @property
    def radius(self) -> float:
        """Distance from the centre of movement to the farthest corner, m."""
        return hypot(max(self.outline.front, self.outline.back), self.outline.side)

    def poses(self, now: Wheels, wanted: Wheels, seconds: float) -> list[tuple[float, float, float, float]]:
        """Return the poses of the coming motion, as x, y, heading and path length.

        Positions are in the body's present frame. The path length (m) is an upper bound for how far any point of the
        body has moved.

        Args:
            now: The present wheel speeds.
            wanted: The commanded wheel speeds from now on.
            seconds: How far to look ahead.
        """
        found = []
        x = y = heading = moved = 0.0
        for _ in range(math.ceil(seconds / self.period)):
            now = now.lagged(wanted, self.inertia)
            travel, turn = (now.left + now.right) / 2.0 * self.period, (now.right - now.left) / self.track * self.period
            reach = abs(travel) + abs(turn) * self.radius
            pieces = max(1, math.ceil(reach / STEP))
            travel, turn, reach = travel / pieces, turn / pieces, reach / pieces
            for _ in range(pieces):
                s, c = sincos(heading + turn / 2.0)
                x += travel * c
                y += travel * s
                heading += turn
                moved += reach
                found.append((x, y, heading, moved))
        return found

    def watched(self, points: Iterable[Point], margin: float, swing: float, longest: float) -> list[WatchedPoint]:
        """Return the points that matter to a motion, each with the clearances it must keep.

        Args:
            points: Obstacle points, in the body's present frame.
            margin: The clearance to keep, m; where there is less now, `CLEARANCE_SHARE` of it may be used up.
            swing: Metres added to both ends of the footprint, to keep room for a later turn in place.
            longest: The farthest that any point of the body moves, m.
        """
        found = []
        for x, y in points:
            lengthened = self.clearance(x, y, swing)
            if lengthened - margin <= longest:
                clearance = self.clearance(x, y, 0.0)
                spent = CLEARANCE_SHARE * max(0.0, clearance)
                least, least_long = min(margin, clearance - spent), min(margin, lengthened - spent)
                found.append((min(clearance - least, lengthened - least_long), x, y, least, least_long))
        return found

    def is_free(
        self, poses: Sequence[tuple[float, float, float, float]], watched: Sequence[WatchedPoint], swing: float
    ) -> bool:
        """Return whether every point keeps its clearances along a motion.

        Args:
            poses: The motion, from `poses`.
            watched: The points, from `watched` with a `longest` no shorter than this motion.
            swing: The same as there.
        """
        body = self.outline
        middle, half, side = (body.front - body.back) / 2.0, (body.front + body.back) / 2.0, body.side
        # No point can have come too near before the body has moved as far as the point has to spare. The heap has the
        # point first that is to be checked first; points beyond the whole motion are never checked.
        due = [point for point in watched if point[0] <= poses[-1][3]] if poses else []
        heapq.heapify(due)
        for px, py, heading, moved in poses:
            if not due:
                break
            if due[0][0] > moved:
                continue
            s, c = sincos(heading)
            while due[0][0] <= moved:
                _, x, y, least, least_long = due[0]
                # `clearance` twice, inlined: most of a tick's time is spent here.
                dx, dy = x - px, y - py
                along = abs(c * dx + s * dy - middle) - half
                across = abs(c * dy - s * dx) - side
                square = across * across
                if along <= 0.0 or across <= 0.0:
                    spare = max(along, across) - least
                else:
                    spare = math.sqrt(along * along + square) - least
                along -= swing
                if along <= 0.0 or across <= 0.0:
                    spare_long = max(along, across) - least_long
                else:
                    spare_long = math.sqrt(along * along + square) - least_long
                spare = min(spare, spare_long)
                if spare < 0.0:
                    return False
                later = max(moved + spare, math.nextafter(moved, math.inf))
                heapq.heapreplace(due, (later, x, y, least, least_long))
        return True
