"""How a pedestrian passes a doorway among others: who is nearer goes first, the others keep a gap.

    v = v0 cos(turn), at most gap / T1, (gap + G) / T2 and yield_gap / T1
    heading = the one that minimises D^2 + f^2 - 2 D f cos(off)

gap is free ahead of the body, and yield_gap is free before those who go first, less `KEEP`. f is how far the pedestrian
could walk in a direction before the first collision if all others kept their velocities, D the farthest it looks, and
off is the angle from the direction to the middle of the doorway. It does not walk around those who go first.

Whoever is nearer to the doorway goes first. If two are equally near, the one on the right does: seen from a doorway,
this rule has no circles. If all stand, each loses patience at a rate of its own, drawn at random, and counts that as
nearness. So two who both give way do not wait for ever, and nobody waits for what never moves. Two shoulders in a
doorway would block each other: who does not get on near it for some seconds, while none of those who go first moves,
steps back for a moment.

Sources: M. Moussaid, D. Helbing, G. Theraulaz, How simple rules determine pedestrian behavior and crowd disasters,
PNAS 108, 2011 (heading). A. Tordeux, M. Chraibi, A. Seyfried, Collision-free speed model for pedestrian dynamics,
Traffic and Granular Flow '15, 2016 (speed from the gap). The order and all numbers are our own choice. The numbers are
fitted to the published flow: see `tests/agents/person_trials.py`.
"""

from __future__ import annotations

import math
import random
from typing import NamedTuple

from intellwheels_agents.differential_drive import Odometry, wrapped
from intellwheels_agents.doorways import WIDEST, Doorway, near_wall
from intellwheels_agents.portable_math import atan2, cos, dist, hypot, sincos
from intellwheels_agents.range_ring import RANGE, WIDTH, RangeRing
from intellwheels_agents.range_scan import Outline

ZONE = 3.5
"""Distance from a doorway within which its order holds, m."""
PASSED = 0.3
"""Distance behind a doorway at which it is passed, m."""
AIM_BEFORE, AIM_BEHIND = 0.55, 0.45
"""It walks to a point so far before the doorway until it can pass straight on, then to one behind it, m."""
TIME_GAP = 0.2
"""T1, s: shortest time in which a gap may be used up."""
FOLLOWING_GAP, FOLLOWING_TIME = 0.3, 0.45
"""G, m, and T2, s: of those who follow through a doorway. They hurry more than in a corridor."""
KEEP = 0.3
"""Gap to those who go first, m: all have room to turn."""
TIE = 0.1
"""Two whose distances differ by less are equally near, m."""
HALF_DEPTH = 0.15
"""Distance from the middle of what is seen of a person to the centre, m."""
CIRCLE = 0.29
"""Clearance of the centre from others on a free way, m."""
STRIP = 0.02
"""Added to each side of the body for what is nearer than `CIRCLE`, m."""
HORIZON = 3.0
"""Farthest that a collision counts, m."""
HEADINGS = 24
"""Headings that are considered besides the direct one, a cone apart."""
ORDER_RANGE = 2.5
"""Others up to this far away count for the order, m."""
HALF_FIELD = math.radians(100.0)
"""It waits for those up to this far from its direction."""
JUMP = 0.25
"""Two neighbouring ranges that differ by less belong to one body, m."""
MOVES = 0.15
"""Speed of somebody who is on his way, m/s."""
STANDS = 0.05
"""Speed below which it stands itself, m/s."""
SLOWEST_LOSS, FASTEST_LOSS = 0.1, 1.0
"""Range of the rate at which patience is lost, m/s."""
BACK_ZONE = 1.2
"""It makes room only within this distance from a doorway, m."""
PROGRESS = 0.3
"""Whoever moves less does not get on, m: one who is jammed moves to and fro."""
STANDS_BEFORE_BACK = 2.0, 4.0
"""Range of the time without progress, while none of those who go first moves, before it steps back, s."""
STEPS_BACK = 0.4, 1.0
"""Range of the time for which it steps back, s."""
PATIENCE_BACK = 0.5
"""Rate at which patience comes back while somebody moves, m/s."""


class DoorStep(NamedTuple):
    """What to do before a doorway.

    Attributes:
        off: Angle of the best heading from the present one, rad.
        limit: Highest speed because of others, m/s.
        yields: Whether it stands because others go first.
        back: Whether to step back, if the way is free.
    """

    off: float
    limit: float
    yields: bool
    back: bool


class Seen(NamedTuple):
    """The nearest point in a cone, in the frame of the doorway and relative to the pedestrian.

    Attributes:
        x, y: Its place, m.
        vx, vy: Its velocity, m/s.
        metres: Its distance, m.
        bearing: Its direction from the pedestrian's heading, rad.
    """

    x: float
    y: float
    vx: float
    vy: float
    metres: float
    bearing: float


class DoorwayQueue:
    """A pedestrian's place in the order before a doorway."""

    def __init__(self, body: Outline, name: str) -> None:
        """Take the outline of the body, and the name of the pedestrian, which is the seed of its patience."""
        self._body = body
        self._random = random.Random(name)  # noqa: S311 - for variety, not for secrets
        self._impatience = 0.0
        self._loss = 0.0
        self._stood = 0.0
        self._stands_at = (math.inf, 0.0)
        self._room_after = self._random.uniform(*STANDS_BEFORE_BACK)
        self._back = 0.0

    def step(
        self, door: Doorway, pose: Odometry, ring: RangeRing, wanted: float, speed: float, period: float
    ) -> DoorStep:
        """Return the step of a tick.

        Args:
            door: The doorway to pass.
            pose: The pedestrian's pose.
            ring: What it sees.
            wanted: Its preferred speed, m/s.
            speed: Its present speed, m/s.
            period: Length of a tick, s.
        """
        x, y = door.local(pose.x, pose.y)
        heading = wrapped(pose.heading - atan2(door.uy, door.ux))
        aim_x, aim_y = aim(door, x, y)
        direct = atan2(aim_y - y, aim_x - x)
        seen = self._seen(ring, pose.heading, heading)
        first, moving = self._first(door, pose, heading, (x, y), direct, seen)
        gap = min(
            (
                seen[i].metres - self._extent(seen[i].bearing) - KEEP
                for i in first
                if abs(wrapped(seen[i].bearing + heading - direct)) < HALF_FIELD
            ),
            default=math.inf,
        )
        gap = max(gap, 0.0)
        self._wait(gap, speed, period, moving=moving)
        self._make_room((x, y), period, moving=moving)
        others = [one for i, one in enumerate(seen) if i not in first]
        off = wrapped(self._heading(others, direct, wanted, hypot(aim_x - x, aim_y - y)) - heading)
        ahead = ring.gap()
        limit = min(gap / TIME_GAP, ahead / TIME_GAP, (ahead + FOLLOWING_GAP) / FOLLOWING_TIME)
        return DoorStep(off, limit, gap < KEEP / 3.0, self._back > 0.0)

    def _seen(self, ring: RangeRing, pose_heading: float, heading: float) -> list[Seen]:
        """Return the nearest points of all cones, by bearing; they are in the order of the cones."""
        s, c = sincos(heading)
        found = []
        for x, y, vx, vy in ring.near(RANGE, pose_heading):
            metres = math.sqrt(x * x + y * y)
            found.append(Seen(c * x - s * y, s * x + c * y, c * vx - s * vy, s * vx + c * vy, metres, atan2(y, x)))
        return found

    def _first(
        self, door: Doorway, pose: Odometry, heading: float, own: tuple[float, float], direct: float, seen: list[Seen]
    ) -> tuple[set[int], bool]:
        """Return the points of those who go first, as indices of `seen`, and whether one of them moves."""
        first: set[int] = set()
        moving = False
        if own[0] >= 0.0:
            return first, moving
        s, c = sincos(direct)
        rank = hypot(*own) - self._impatience
        for body in self._bodies(door, pose, heading, seen):
            x = math.fsum(seen[i].x for i in body) / len(body)
            y = math.fsum(seen[i].y for i in body) / len(body)
            share = 1.0 + HALF_DEPTH / max(hypot(x, y), 1e-6)
            there_x, there_y = own[0] + share * x, own[1] + share * y
            if there_x > 0.05:
                continue
            other = hypot(there_x, there_y)
            on_the_right = c * y - s * x < 0.0
            if other < rank - TIE or (other < rank + TIE and on_the_right):
                first.update(body)
                moving = moving or any(hypot(seen[i].vx, seen[i].vy) > MOVES for i in body)
        return first, moving

    def _bodies(self, door: Doorway, pose: Odometry, heading: float, seen: list[Seen]) -> list[list[int]]:
        """Return the points of each body in `ORDER_RANGE` that is no wall of the map."""
        turn = pose.heading - heading
        s, c = sincos(turn)
        found: list[list[int]] = []
        last = None
        for i, one in enumerate(seen):
            if one.metres > ORDER_RANGE:
                continue
            x, y = pose.x + c * one.x - s * one.y, pose.y + s * one.x + c * one.y
            if near_wall(door.walls, x, y, 0.1 + 0.03 * one.metres):
                continue
            if (
                last is not None
                and abs(one.metres - last.metres) < JUMP
                and abs(wrapped(one.bearing - last.bearing)) < 1.5 * WIDTH
            ):
                found[-1].append(i)
            else:
                found.append([i])
            last = one
        return found

    def _wait(self, gap: float, speed: float, period: float, *, moving: bool) -> None:
        """Lose patience where all stand; it comes back where somebody moves."""
        if speed < STANDS and not moving and gap < KEEP / 2.0:
            if self._loss == 0.0:
                self._loss = self._random.uniform(SLOWEST_LOSS, FASTEST_LOSS)
            self._impatience += self._loss * period
        elif moving or speed >= 2.0 * STANDS:
            self._impatience = max(self._impatience - PATIENCE_BACK * period, 0.0)
            self._loss = 0.0

    def _make_room(self, own: tuple[float, float], period: float, *, moving: bool) -> None:
        """Decide whether to step back: two who stand shoulder to shoulder before a doorway block each other."""
        self._back = max(self._back - period, 0.0)
        self._stood += period
        if moving or hypot(*own) > BACK_ZONE or dist(own, self._stands_at) > PROGRESS:
            self._stood, self._stands_at = 0.0, own
        if self._stood > self._room_after:
            self._stood, self._room_after = 0.0, self._random.uniform(*STANDS_BEFORE_BACK)
            self._back = self._random.uniform(*STEPS_BACK)

    def _heading(self, others: list[Seen], direct: float, wanted: float, away: float) -> float:
        """Return the best heading in the frame of the doorway, rad."""
        far = min(HORIZON, max(away, 1.0))
        strip = self._body.side + STRIP
        best, least = direct, math.inf
        for step in range(HEADINGS + 1):
            turn = ((step + 1) // 2) * (WIDTH if step % 2 else -WIDTH)
            s, c = sincos(direct + turn)
            free = wanted * time_to_collision(others, wanted * c, wanted * s, far / wanted, strip)
            cost = far * far + free * free - 2.0 * far * free * cos(turn)
            if cost < least - 1e-9:
                best, least = direct + turn, cost
        return best

    def _extent(self, bearing: float) -> float:
        """Return the distance from the centre of the body to its edge, m."""
        s, c = sincos(bearing)
        along = (self._body.front if c > 0.0 else self._body.back) / max(abs(c), 1e-9)
        return min(along, self._body.side / max(abs(s), 1e-9))


def aim(door: Doorway, x: float, y: float) -> tuple[float, float]:
    """Return where to walk from a point, all in the frame of the doorway, m.

    Through a doorway wider than `WIDEST` it walks where it comes, else through the middle.
    """
    beside = max(door.width - WIDEST, 0.0) / 2.0
    clear = door.width / 2.0 - 0.15 if x > -0.35 else beside + 0.12 - 0.5 * x
    return (AIM_BEHIND if abs(y) < clear else -AIM_BEFORE), min(max(y, -beside), beside)


def time_to_collision(others: list[Seen], vx: float, vy: float, most: float, strip: float) -> float:
    """Return the time until a pedestrian with a velocity is within `CIRCLE` of one of the others, s.

    Args:
        others: The others; they keep their velocities.
        vx: The pedestrian's velocity along x, m/s.
        vy: The same along y, m/s.
        most: The longest time that counts, s.
        strip: Half of the width of the way that one nearer than `CIRCLE` blocks, m.
    """
    time = most
    for one in others:
        wx, wy = vx - one.vx, vy - one.vy
        towards = one.x * wx + one.y * wy
        if towards <= 0.0:
            continue
        ww, square = wx * wx + wy * wy, one.metres * one.metres
        excess = square - CIRCLE * CIRCLE
        if excess <= 0.0:
            if square - towards * towards / ww < strip * strip:
                return 0.0
            continue
        root = towards * towards - ww * excess
        if root > 0.0:
            time = min(time, (towards - math.sqrt(root)) / ww)
    return time
