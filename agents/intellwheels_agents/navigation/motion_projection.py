"""Projects a body's footprint along its motion, and says whether it comes too near to an obstacle.

The wheels follow their command as the motors let them, then brake, and the body follows the arcs that they roll. A
motion is free if no obstacle point comes nearer than its own limit until the body stands.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from intellwheels_agents.footprint import STEP
from intellwheels_agents.navigation.point_cells import Floats
from intellwheels_agents.portable_math import hypot, sincos
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

CHUNK: Final = 12
"""Poses that are checked together; a motion that is not free mostly shows it at its beginning."""


class WatchedPoints(NamedTuple):
    """The points that matter to a motion, those that the body can be near first.

    Attributes:
        slack: How far the body can move before each point can come too near, m.
        x, y: The points in the body's present frame, m.
        least: The least clearances to the footprint, m.
        least_long: The least clearances to the lengthened footprint, m.
    """

    slack: Floats
    x: Floats
    y: Floats
    least: Floats
    least_long: Floats


@dataclass(frozen=True, slots=True)
class MotionProjection:
    """Projects the motion of one body, from its outline, track (m) and motors.

    Attributes:
        radius: Distance from the centre of movement to the farthest corner, m.
    """

    outline: Outline
    track: float
    motors: Motors
    radius: float = field(init=False)

    def __post_init__(self) -> None:
        body = self.outline
        object.__setattr__(self, "radius", hypot(max(body.front, body.back), body.side))

    def clearance(self, x: Floats, y: Floats, swing: float) -> Floats:
        """Return the distances from the footprint to points in m, negative inside; `swing` lengthens both ends."""
        body = self.outline
        middle, half = (body.front - body.back) / 2.0, (body.front + body.back) / 2.0 + swing
        return _outside(np.abs(x - middle) - half, np.abs(y) - body.side)

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
        wheel = self.motors.wheel
        left, rolled_left = wheel(now.left, wanted.left)
        right, rolled_right = wheel(now.right, wanted.right)
        now = Wheels(left, right)
        travel, turn = (rolled_left + rolled_right) / 2.0, (rolled_right - rolled_left) / self.track
        reach = abs(travel) + abs(turn) * self.radius
        pieces = max(1, math.ceil(reach / STEP))
        travel, turn, reach = travel / pieces, turn / pieces, reach / pieces
        x, y, heading, moved = pose
        half = turn / 2.0
        s, c = sincos(heading + half)
        for piece in range(pieces):
            if piece and turn != 0.0:
                s, c = sincos(heading + half)
            x += travel * c
            y += travel * s
            heading += turn
            moved += reach
            if passed is not None:
                passed.append((x, y, heading, moved))
        return now, (x, y, heading, moved)

    def watched(self, points: Floats, margin: float, swing: float, longest: float) -> WatchedPoints:
        """Return the points that matter to a motion, each with the clearances it must keep.

        Args:
            points: Obstacle points in the body's present frame, of shape (n, 2), m.
            margin: The clearance to keep, m; where there is less now, `CLEARANCE_SHARE` of it may be used up.
            swing: Metres added to both ends of the footprint, to keep room for a later turn in place.
            longest: The farthest that any point of the body moves, m.
        """
        x, y = points[:, 0], points[:, 1]
        lengthened = self.clearance(x, y, swing)
        near = lengthened <= longest + margin
        x, y, lengthened = x[near], y[near], lengthened[near]
        clearance = self.clearance(x, y, 0.0)
        spent = np.maximum(CLEARANCE_SHARE * (clearance - FLOOR), ROUNDING)
        least, least_long = np.minimum(margin, clearance - spent), np.minimum(margin, lengthened - spent)
        slack = np.minimum(clearance - least, lengthened - least_long)
        first = np.argsort(slack, kind="stable")
        return WatchedPoints(slack[first], x[first], y[first], least[first], least_long[first])

    def is_free(self, poses: Sequence[tuple[float, float, float, float]], watched: WatchedPoints, swing: float) -> bool:
        """Return whether every point keeps its clearances along a motion.

        Args:
            poses: The motion, from `poses`.
            watched: The points, from `watched` with a `longest` no shorter than this motion.
            swing: The same as there.
        """
        body = self.outline
        middle, half, side = (body.front - body.back) / 2.0, (body.front + body.back) / 2.0, body.side
        for begin in range(0, len(poses), CHUNK):
            chunk = poses[begin : begin + CHUNK]
            # No point can have come too near before the body has moved as far as the point has to spare.
            count = int(np.searchsorted(watched.slack, chunk[-1][3], side="right"))
            if count == 0:
                continue
            px, py, s, c = np.array([(px, py, *sincos(heading)) for px, py, heading, _ in chunk]).T[:, :, None]
            dx, dy = watched.x[:count] - px, watched.y[:count] - py
            along = np.abs(c * dx + s * dy - middle) - half
            across = np.abs(c * dy - s * dx) - side
            if (_outside(along, across) < watched.least[:count]).any():
                return False
            if swing and (_outside(along - swing, across) < watched.least_long[:count]).any():
                return False
        return True


def _outside(along: Floats, across: Floats) -> Floats:
    """Return the distances from a rectangle to points that are so far beyond its ends and its sides, m."""
    nearer = np.maximum(along, across)
    return np.where(np.minimum(along, across) <= 0.0, nearer, np.sqrt(along * along + across * across))
