"""Emotional interaction: a pedestrian is drawn to companions and keeps away from those he shuns.

    g = A towards the centre of the group, while it is farther than (n - 1) / 2 metres
    f = (V / s) exp(-d / s) away from each who is shunned, at a distance d

with n the number of people in the group. With the force (v0 e - v) / tau of the goal, where e is the unit vector to it,
the velocity settles at v0 e + tau (g + sum of f).

Sources: the IntellWheels Simulator paper (2009) names emotional interaction, "movement conditioned by attraction or
repulsion". M. Moussaid, N. Perozo, S. Garnier, D. Helbing, G. Theraulaz, The walking behaviour of pedestrian social
groups and its impact on crowd dynamics, PLoS ONE 5, 2010 (the form of g). D. Helbing, P. Molnar, Social force model for
pedestrian dynamics, Phys. Rev. E 51, 1995 (tau, V, the form of f). `ATTRACTION` and `REACH` are chosen.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from intellwheels_agents.portable_math import exp, hypot
from intellwheels_agents.pure_pursuit import Point

RELAXATION = 0.5
"""tau, s."""
ATTRACTION = 1.0
"""A, m/s2."""
POTENTIAL = 2.1
"""V, m2/s2."""
REACH = 1.0
"""s, m: 0.3 m in the source for strangers. It is felt from about 2 m on."""


def attraction(own: Point, companions: Sequence[Point]) -> Point:
    """Return the force (m/s2) towards the group, from one's own position and the companions' (m)."""
    if not companions:
        return 0.0, 0.0
    count = len(companions) + 1
    x = math.fsum((own[0], *(x for x, _ in companions))) / count - own[0]
    y = math.fsum((own[1], *(y for _, y in companions))) / count - own[1]
    off = hypot(x, y)
    if off <= (count - 1) / 2.0:
        return 0.0, 0.0
    return ATTRACTION * x / off, ATTRACTION * y / off


def repulsion(own: Point, shunned: Sequence[Point]) -> Point:
    """Return the sum of the forces (m/s2) away from those who are shunned, from the positions (m)."""
    push_x = push_y = 0.0
    for x, y in shunned:
        away_x, away_y = own[0] - x, own[1] - y
        distance = max(hypot(away_x, away_y), 1e-9)
        force = POTENTIAL / REACH * exp(-distance / REACH) / distance
        push_x += force * away_x
        push_y += force * away_y
    return push_x, push_y
