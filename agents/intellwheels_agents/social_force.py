"""The social force model: what draws somebody who walks, and what keeps him off.

    dv/dt = (v0 e - v) / tau + sum of f + g
    f = (V / s) exp(-b / s), away from a thing
    g = A towards the middle of the company, while it is further than (n - 1) / 2 metres

with e the way to the goal and n the number of the company. b is the half axis of the ellipse round where the thing is
and where it will be in a step of `STEP` seconds: who comes nearer is felt from afar, who walks along hardly. What is
behind is felt by a share. To round what comes straight on the force has a part beside the way too, to the right when
there is nothing to choose; without it two who meet head on only slow each other down.

Sources: D. Helbing, P. Molnar, Social force model for pedestrian dynamics, Phys. Rev. E 51, 1995 (v0, tau, V, s, the
angle of sight). A. Johansson, D. Helbing, P. Shukla, Specification of the social force pedestrian model by evolutionary
adjustment to video tracking data, Adv. Complex Systems 10, 2007 (the share behind, who moves relative to whom).
M. Moussaid, N. Perozo, S. Garnier, D. Helbing, G. Theraulaz, The walking behaviour of pedestrian social groups and its
impact on crowd dynamics, PLoS ONE 5, 2010 (the form of g). `STEP`, `ATTRACTION` and the part beside are chosen here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from intellwheels_agents.differential_drive import wrapped
from intellwheels_agents.pure_pursuit import Point
from intellwheels_agents.range_ring import Thing

LIKED = 1.34
"""Metres a second, v0."""
RELAXATION = 0.5
"""Seconds, tau."""
POTENTIAL = 2.1
"""Square metres per square second, V."""
REACH = 0.3
"""Metres, s."""
STEP = 1.5
"""Seconds of somebody else's walk that are reckoned with."""
ATTRACTION = 1.0
"""Metres a second squared, A."""
HALF_DEPTH = 0.2
"""Metres from the surface of a person to its middle."""
BEHIND = 0.1
"""Share by which what is out of sight is felt."""
SIGHT_ANGLE = math.radians(100.0)
"""What lies further than this off the way is out of sight."""
TO_THE_RIGHT = math.radians(5.0)
"""What is no further than this to the right is straight ahead."""


def drive(wanted: Point, velocity: Point) -> Point:
    """Return the force, m/s2, that takes a velocity to the wanted one, both m/s."""
    return (wanted[0] - velocity[0]) / RELAXATION, (wanted[1] - velocity[1]) / RELAXATION


def attraction(own: Point, company: Sequence[Point]) -> Point:
    """Return the force, m/s2, of the others of a company, by where they are, m."""
    if not company:
        return 0.0, 0.0
    count = len(company) + 1
    x = sum((x for x, _ in company), own[0]) / count - own[0]
    y = sum((y for _, y in company), own[1]) / count - own[1]
    off = math.hypot(x, y)
    if off <= (count - 1) / 2.0:
        return 0.0, 0.0
    return ATTRACTION * x / off, ATTRACTION * y / off


def repulsion(things: Iterable[Thing], wanted: Point, velocity: Point, moves: Point, heading: float) -> Point:
    """Return the sum of the forces of what is near, m/s2.

    Args:
        things: That are near.
        wanted: The velocity that is liked best, m/s; 0 for who stands.
        velocity: Own, as last decided, m/s.
        moves: Own, as it came out, m/s.
        heading: Own, rad; the way of who stands.
    """
    liked = math.hypot(*wanted)
    way = math.atan2(wanted[1], wanted[0]) if liked > 0.0 else heading
    push_x = push_y = 0.0
    for thing in things:
        off = wrapped(thing.bearing - way)
        force, away_x, away_y = elliptic(thing, moves)
        if liked > 0.0 and abs(off) > SIGHT_ANGLE:
            force *= BEHIND
        to_x, to_y = math.cos(thing.bearing), math.sin(thing.bearing)
        closing = (velocity[0] - thing.velocity_x) * to_x + (velocity[1] - thing.velocity_y) * to_y
        if liked > 0.0 and closing > 0.0 and abs(off) < math.pi / 2.0:
            # Round it, on the side it is not. The ellipse's own side changes with what is seen of the thing, and
            # would lead to and fro.
            away_x, away_y = -to_x, -to_y
            beside = way + math.copysign(math.pi / 2.0, -off - TO_THE_RIGHT)
            aside = force * math.cos(off) * min(closing / liked, 1.0)
            push_x += aside * math.cos(beside)
            push_y += aside * math.sin(beside)
        push_x += force * away_x
        push_y += force * away_y
    return push_x, push_y


def elliptic(thing: Thing, moves: Point) -> tuple[float, float, float]:
    """Return the force of a thing on who moves so fast (m/s): m/s2, and the unit vector of its direction."""
    middle = thing.metres + HALF_DEPTH
    x, y = -middle * math.cos(thing.bearing), -middle * math.sin(thing.bearing)
    step_x, step_y = STEP * (thing.velocity_x - moves[0]), STEP * (thing.velocity_y - moves[1])
    later_x, later_y = x - step_x, y - step_y
    later = max(math.hypot(later_x, later_y), 1e-6)
    half_axis = math.sqrt(max((middle + later) ** 2 - step_x**2 - step_y**2, 0.0)) / 2.0
    force = POTENTIAL / REACH * math.exp(-half_axis / REACH)
    # The normal of the ellipse halves the angle to its two foci.
    away_x, away_y = x / middle + later_x / later, y / middle + later_y / later
    length = math.hypot(away_x, away_y)
    if length < 0.05:
        # On the way of the thing: to the right, seen by it.
        step = max(math.hypot(step_x, step_y), 1e-6)
        return force, step_y / step, -step_x / step
    return force, away_x / length, away_y / length
