"""Where a body's footprint will go, and whether that leads into something.

The wheels lag behind their command as the motors do (equation (1) of the IntellWheels simulator paper, s' = a s +
(1 - a) s*, a the `AccelerationCurve`); the body follows the arcs they roll. A way is free when no point comes
nearer than it may.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from intellwheels_agents.range_scan import Outline

STRIDE: Final = 0.03
"""Metres any place of the footprint moves at most between two looks."""
CREEP: Final = 0.1
"""Share of the room that is left which a way may cost; where it is short of the margin. Whoever rests beside a wall
can so drive along it, and never comes to touch it."""

Point = tuple[float, float]
Watched = tuple[float, float, float, float]
"""A point, x and y, and the least room it may come to: to the footprint, and to the longer one."""


@dataclass(frozen=True, slots=True)
class Wheels:
    """Speeds of the wheels, m/s."""

    left: float
    right: float

    def lagged(self, wanted: Wheels, inertia: float) -> Wheels:
        """Return the speeds a tick later."""
        return Wheels(
            inertia * self.left + (1.0 - inertia) * wanted.left, inertia * self.right + (1.0 - inertia) * wanted.right
        )


@dataclass(frozen=True, slots=True)
class MotionProjection:
    """A body's outline, its track (m), its inertia and the simulation's period (s)."""

    outline: Outline
    track: float
    inertia: float
    period: float

    def clearance(self, x: float, y: float, swing: float) -> float:
        """Return metres from the footprint, made longer by `swing` at both ends, to a point; inside negative."""
        body = self.outline
        middle, half = (body.front - body.back) / 2.0, (body.front + body.back) / 2.0 + swing
        dx, dy = abs(x - middle) - half, abs(y) - body.side
        if dx <= 0.0 or dy <= 0.0:
            return max(dx, dy)
        return math.hypot(dx, dy)

    @property
    def radius(self) -> float:
        """Metres from the centre of movement to the furthest corner."""
        return math.hypot(max(self.outline.front, self.outline.back), self.outline.side)

    def poses(self, now: Wheels, wanted: Wheels, seconds: float) -> list[tuple[float, float, float, float]]:
        """Return where the body will be: x, y, heading in its frame of now, and metres that any place of it moved.

        Args:
            now: Its wheels.
            wanted: What they are told from now on.
            seconds: How far to look ahead.
        """
        found = []
        x = y = heading = moved = 0.0
        for _ in range(math.ceil(seconds / self.period)):
            now = now.lagged(wanted, self.inertia)
            travel, turn = (now.left + now.right) / 2.0 * self.period, (now.right - now.left) / self.track * self.period
            reach = abs(travel) + abs(turn) * self.radius
            pieces = max(1, math.ceil(reach / STRIDE))
            travel, turn, reach = travel / pieces, turn / pieces, reach / pieces
            for _ in range(pieces):
                x += travel * math.cos(heading + turn / 2.0)
                y += travel * math.sin(heading + turn / 2.0)
                heading += turn
                moved += reach
                found.append((x, y, heading, moved))
        return found

    def watched(self, points: Iterable[Point], margin: float, swing: float, longest: float) -> list[Watched]:
        """Return which points matter to a way, with their room now and the least that it may come to.

        Args:
            points: What stands there, in the body's frame of now.
            margin: Metres to keep; where there is less now, about that.
            swing: Metres by which the footprint counts as longer at both ends, to have room to turn by later.
            longest: Metres that any place of the body moves at most.
        """
        found = []
        body = self.outline
        middle, half = (body.front - body.back) / 2.0, (body.front + body.back) / 2.0 + swing
        for x, y in points:
            # As `clearance`, written out for the many points that are far.
            dx, dy = abs(x - middle) - half, abs(y) - body.side
            wide = max(dx, dy) if dx <= 0.0 or dy <= 0.0 else math.hypot(dx, dy)
            if wide - margin <= longest:
                room = self.clearance(x, y, 0.0)
                spent = CREEP * max(0.0, room)
                found.append((x, y, min(margin, room - spent), min(margin, wide - spent)))
        return found

    def is_free(
        self, poses: Sequence[tuple[float, float, float, float]], watched: Sequence[Watched], swing: float
    ) -> bool:
        """Return whether no point comes nearer than it may.

        Args:
            poses: As `poses` returns them.
            watched: As `watched` returns them, for at least as long a way.
            swing: As there.
        """
        body = self.outline
        middle, half, side = (body.front - body.back) / 2.0, (body.front + body.back) / 2.0, body.side
        places = [(x, y, math.cos(heading), math.sin(heading)) for x, y, heading, _ in poses]
        moved = [pose[3] for pose in poses]
        count = len(moved)
        for x, y, least, least_wide in watched:
            look = 0
            while look < count:
                # As `clearance`, twice, written out without calls: most of a tick is spent here.
                px, py, c, s = places[look]
                dx, dy = x - px, y - py
                along, across = c * dx + s * dy - middle, c * dy - s * dx
                along = (along if along > 0.0 else -along) - half
                across = (across if across > 0.0 else -across) - side
                if along > 0.0 and across > 0.0:
                    room = math.hypot(along, across) - least
                else:
                    room = (along if along > across else across) - least  # noqa: FURB136 - a call costs
                along -= swing
                if along > 0.0 and across > 0.0:
                    wide = math.hypot(along, across) - least_wide
                else:
                    wide = (along if along > across else across) - least_wide  # noqa: FURB136
                slack = room if room < wide else wide  # noqa: FURB136
                if slack < 0.0:
                    return False
                # The point cannot come nearer by more than the body moves: until then it needs no other look.
                look = bisect_left(moved, moved[look] + slack, look + 1)
        return True
