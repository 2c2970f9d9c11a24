"""How a pedestrian chooses a direction and a speed.

Direction: of all directions within `FIELD` of the goal, the one that leads nearest to the goal as far as the way is
free. With f(a) the free distance in direction a among objects that keep their velocities, a0 the direction of the goal
and H the horizon, it minimises

    d(a)^2 = H^2 + f(a)^2 - 2 H f(a) cos(a0 - a)

Speed: v = min(v0, gap / T), with the gap to the nearest object in the strip ahead.

Before a narrow passage whoever is nearer to it goes first: the others keep `QUEUE` from him, also beside him. Without
this rule those who arrive together block each other in the frame (an arch).

Sources: M. Moussaid, D. Helbing, G. Theraulaz, How simple rules determine pedestrian behavior and crowd disasters, PNAS
108, 2011 (direction). A. Tordeux, M. Chraibi, A. Seyfried, Collision-free speed model for pedestrian dynamics, Traffic
and Granular Flow '15, 2016 (speed). U. Weidmann, Transporttechnik der Fussgaenger, ETH Zurich, 1993 (v0). The rule for
passages is chosen here. T was fitted: in a corridor to Weidmann's speeds at 1 and 2 people a square metre, in a passage
to the flow through doors. Numbers without a source are chosen.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from intellwheels_agents.footprint import MovingPoint
from intellwheels_agents.portable_math import cos, hypot, sincos
from intellwheels_agents.pure_pursuit import Point

PREFERRED_SPEED = 1.34
"""v0, m/s (Weidmann 1993)."""
TIME_GAP = 0.6
"""T in the open, s (fitted)."""
PASSAGE_TIME_GAP = 0.2
"""T in a narrow passage, s (fitted)."""
FIELD = math.radians(90.0)
"""Largest angle between the direction and the goal, rad; 75 degrees in the source."""
STEP = math.radians(7.5)
"""Between two directions that are compared, rad (chosen)."""
HORIZON = 5.0
"""H, m (chosen; 10 m in the source)."""
RADIUS = 0.28
"""Radius of the disc for which a way is free, m: half of the width of a person and 3 cm (chosen)."""
BERTH = 0.3
"""Clearance kept to a chair beyond that to people, m (chosen)."""
STRIP = 0.27
"""Half of the width of the strip ahead, m: half of the width of a person and 2 cm (chosen)."""
KEEP = 0.15
"""By how much, m, another direction must be nearer to the goal than the present one (chosen)."""
TO_THE_RIGHT = 0.05
"""By how much, m, a direction to the left must be nearer to the goal than one to the right (chosen)."""
INSIDE = 0.5
"""Cosine of the angle to an object nearer than `RADIUS` above which the way towards it is not free (chosen)."""
QUEUE = 0.45
"""Distance to the surface of who goes first in a passage, m (fitted)."""
QUEUE_REACH = 1.2
"""Distance up to which others count in the queue at a passage, m (chosen)."""
FIRST = 0.2
"""By how much, m, the surface of another must be nearer to the passage than one's own centre (fitted)."""
BESIDE = 0.2
"""Cosine of the angle to the passage below which others do not count in the queue (chosen)."""

_COUNT = round(FIELD / STEP)
_TURNS = tuple(sorted((k * STEP for k in range(-_COUNT, _COUNT + 1)), key=abs))


def free_way(
    points: Sequence[MovingPoint], s: float, c: float, speed: float, horizon: float, radius: float = RADIUS
) -> float:
    """Return how far a pedestrian can walk before he meets a point, m, at most the horizon.

    Args:
        points: Relative to the pedestrian, m and m/s.
        s: Sine of the direction.
        c: Cosine of the direction.
        speed: Of the pedestrian, m/s, more than 0.
        horizon: The most that is returned, m.
        radius: Of the pedestrian's disc, m.
    """
    first = horizon / speed
    own_x, own_y, square = speed * c, speed * s, radius * radius
    for x, y, velocity_x, velocity_y in points:
        x_rate, y_rate = own_x - velocity_x, own_y - velocity_y
        b = x * x_rate + y * y_rate
        if b <= 0.0:
            continue
        away = x * x + y * y - square
        a = x_rate * x_rate + y_rate * y_rate
        if away <= 0.0:
            # Already nearer than the radius: he may pass, but not come nearer head-on.
            if b * b > INSIDE * INSIDE * a * (away + square):
                return 0.0
            continue
        root = b * b - a * away
        if root > 0.0:
            first = min(first, away / (b + math.sqrt(root)))
    return first * speed


def direction(
    points: Sequence[MovingPoint],
    chairs: Sequence[MovingPoint],
    goal: float,
    present: float,
    speed: float,
    horizon: float,
) -> float:
    """Return the direction in which to walk, rad.

    Args:
        points: What is seen, as for `free_way`.
        chairs: Those of them that may belong to moving chairs, from which `BERTH` is kept.
        goal: Direction of the goal, rad.
        present: Direction in which the pedestrian looks, rad.
        speed: Preferred speed, m/s, more than 0.
        horizon: How far he looks, m.
    """
    best, chosen = math.inf, goal
    for turn in _TURNS:
        a = goal + turn
        s, c = sincos(a)
        free = free_way(points, s, c, speed, horizon)
        if chairs:
            free = min(free, free_way(chairs, s, c, speed, horizon, RADIUS + BERTH))
        left = math.sqrt(max(horizon * horizon + free * free - 2.0 * horizon * free * cos(turn), 0.0))
        if abs(math.remainder(a - present, math.tau)) > STEP / 2.0:
            left += KEEP
        if turn > 0.0:
            left += TO_THE_RIGHT
        if left < best - 1e-9:
            best, chosen = left, a
    return chosen


def gap(points: Sequence[MovingPoint], s: float, c: float, front: float) -> float:
    """Return the free distance in the strip ahead, m; infinite if nothing is in it.

    Args:
        points: What is seen, as for `free_way`.
        s: Sine of the direction.
        c: Cosine of the direction.
        front: From the pedestrian's centre to his front, m.
    """
    found = math.inf
    for x, y, _, _ in points:
        along = x * c + y * s
        if along > 0.0 and abs(y * c - x * s) < STRIP:
            found = min(found, along - front)
    return max(found, 0.0)


def queue_gap(others: Sequence[MovingPoint], passage: Point) -> float:
    """Return the free distance to those who are nearer to a passage, m; infinite if nobody is.

    Args:
        others: What is seen apart from the walls, as for `free_way`.
        passage: The middle of the passage, relative to the pedestrian, m.
    """
    found, far = math.inf, hypot(*passage)
    for x, y, _, _ in others:
        away = hypot(x, y)
        if (
            away < QUEUE_REACH
            and hypot(passage[0] - x, passage[1] - y) < far - FIRST
            and x * passage[0] + y * passage[1] > BESIDE * far * away
        ):
            found = min(found, away - QUEUE)
    return max(found, 0.0)
