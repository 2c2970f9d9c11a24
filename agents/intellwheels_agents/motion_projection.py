"""Projects a body's footprint along its motion, and says whether it comes too near to an obstacle.

The wheels follow their command as the motors let them, then brake, and the body follows the arcs that they roll. A
motion is free if no obstacle point comes nearer than its own limit until the body stands.
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
from intellwheels_agents.wheel_motors import STILL, Motors, Wheels

STANDS: Final = 0.01
"""A body with slower wheels stands, m/s."""
LONGEST_BRAKING: Final = 8.0
"""Longest time of braking that is looked at, s: from 1.5 m/s at 0.2 m/s2."""

CLEARANCE_SHARE: Final = 0.1
"""Where the clearance is already below the margin, a motion may use up this share of it. A chair that rests beside a
wall can then drive along it, and never touches it."""

FLOOR: Final = 0.01
"""Clearance of which nothing may be used up, m: many small shares, tick after tick, would add up to a contact. Chosen:
more than a projection is wrong by."""
ROUNDING: Final = 1e-6
"""Loss of clearance that counts as a rounding error, m."""

WatchedPoint = tuple[float, float, float, float, float]
"""How far the body can move before the point can come too near (m), x and y of the point, and its least clearances (m):
to the footprint, and to the lengthened footprint."""


@dataclass(frozen=True, slots=True)
class MotionProjection:
    """Projects the motion of one body, from its outline, track (m) and motors."""

    outline: Outline
    track: float
    motors: Motors

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
        """Return the poses of the coming motion until the body stands, as x, y, heading and path length.

        Positions are in the body's present frame. The path length (m) is an upper bound for how far any point of the
        body has moved.

        Args:
            now: The present wheel speeds.
            wanted: The commanded wheel speeds from now on.
            seconds: For how long they are commanded, at least one cycle; then it brakes.
        """
        found: list[tuple[float, float, float, float]] = []
        pose = (0.0, 0.0, 0.0, 0.0)
        for _ in range(max(1, math.ceil(seconds / self.motors.period - 1e-9))):
            now, pose = self.driven(now, wanted, pose, found)
        for _ in range(math.ceil(LONGEST_BRAKING / self.motors.period)):
            if max(abs(now.left), abs(now.right)) < STANDS:
                break
            now, pose = self.driven(now, STILL, pose, found)
        return found

    def driven(
        self,
        now: Wheels,
        wanted: Wheels,
        pose: tuple[float, float, float, float],
        passed: list[tuple[float, float, float, float]] | None = None,
    ) -> tuple[Wheels, tuple[float, float, float, float]]:
        """Return the wheel speeds and the pose a cycle later; `passed` takes the poses on the way."""
        now, rolled = self.motors.cycle(now, wanted)
        travel, turn = (rolled.left + rolled.right) / 2.0, (rolled.right - rolled.left) / self.track
        reach = abs(travel) + abs(turn) * self.radius
        pieces = max(1, math.ceil(reach / STEP))
        travel, turn, reach = travel / pieces, turn / pieces, reach / pieces
        x, y, heading, moved = pose
        for _ in range(pieces):
            s, c = sincos(heading + turn / 2.0)
            x += travel * c
            y += travel * s
            heading += turn
            moved += reach
            if passed is not None:
                passed.append((x, y, heading, moved))
        return now, (x, y, heading, moved)

    def watched(self, points: Iterable[Point], margin: float, swing: float, longest: float) -> list[WatchedPoint]:
        """Return the points that matter to a motion, each with the clearances it must keep.

        Args:
            points: Obstacle points, in the body's present frame.
            margin: The clearance to keep, m; where there is less now, `CLEARANCE_SHARE` of it may be used up.
            swing: Metres added to both ends of the footprint, to keep room for a later turn in place.
            longest: The farthest that any point of the body moves, m.
        """
        body = self.outline
        middle, half, side = (body.front - body.back) / 2.0, (body.front + body.back) / 2.0 + swing, body.side
        far = longest + margin
        found = []
        for x, y in points:
            # Most points are too far away to matter. It is told here without a call: there are many.
            if abs(x - middle) - half > far or abs(y) - side > far:
                continue
            lengthened = self.clearance(x, y, swing)
            if lengthened <= far:
                clearance = self.clearance(x, y, 0.0)
                spent = max(CLEARANCE_SHARE * (clearance - FLOOR), ROUNDING)
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
