"""Emotional interaction: whom a pedestrian likes attracts it, whom it fears repels it. Pure.

    v = w + v0 (TORN sum of pull(d) u - sum of push(d) u)     with a goal
    v = w pull(d) - v0 sum of push(d) u                       without: w leads to the nearest one that it likes
    pull(d) = (d - NEAR) / RISE, within [0, 1]
    push(d) = MOST (1 - d / SHY), at least 0

with v0 the preferred speed, w the velocity that leads to the goal or to the one it follows, d the distance of another
agent and u the unit vector to it. The length of v is at most v0. In the social force model a wanted velocity v acts as
the force v / tau, so these are its attractive and repulsive effects of other people.

Source: D. Helbing, P. Molnar, Social force model for pedestrian dynamics, Phys. Rev. E 51, 1995 (people attract and
repel as forces do). The forms and all numbers are our own choice.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from intellwheels_agents.portable_math import dist, hypot
from intellwheels_agents.pure_pursuit import Point

NEAR = 1.4
"""Distance between the centres that is near enough to those it likes, m."""
RISE = 1.5
"""From `NEAR`, the attraction grows to its full strength over this distance, m."""
TORN = 0.5
"""Strength of the attraction on a pedestrian with a goal."""
SHY = 4.0
"""Distance within which those it fears repel it, m."""
MOST = 2.0
"""Repulsion at no distance, as a multiple of the preferred speed."""


def pull(own: Point, other: Point) -> float:
    """Return how strongly another one that the pedestrian likes attracts it, 0 to 1; positions in m."""
    return min(max((dist(own, other) - NEAR) / RISE, 0.0), 1.0)


def push(own: Point, other: Point) -> float:
    """Return how strongly another one that the pedestrian fears repels it, 0 to `MOST`; positions in m."""
    return MOST * max(1.0 - dist(own, other) / SHY, 0.0)


def nearest(own: Point, others: Sequence[Point]) -> Point | None:
    """Return the nearest of the others, or None if there are none; all in m."""
    return min(others, key=lambda other: dist(own, other), default=None)


def felt(own: Point, wanted: Point, speed: float, liked: Iterable[Point], feared: Iterable[Point]) -> Point:
    """Return the wanted velocity, m/s, changed by those that the pedestrian likes and fears.

    Args:
        own: Its position, m.
        wanted: The velocity that it would have without them, m/s.
        speed: Its preferred speed, m/s.
        liked: Positions of those it likes, m; none if it follows one of them.
        feared: Positions of those it fears, m.
    """
    shares = [(other, TORN * pull(own, other)) for other in liked]
    shares += [(other, -push(own, other)) for other in feared]
    x, y = wanted
    for other, share in shares:
        metres = max(dist(own, other), 1e-9)
        x += speed * share * (other[0] - own[0]) / metres
        y += speed * share * (other[1] - own[1]) / metres
    excess = max(hypot(x, y) / speed, 1.0)
    return x / excess, y / excess
