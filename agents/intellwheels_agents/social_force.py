"""The social force model of pedestrians: a goal attracts, obstacles and other people repel.

    dv/dt = (v0 e - v) / tau + sum of f + g
    f = (V / s) exp(-b / s), away from an object
    g = A towards the centre of the group, while it is farther than (n - 1) / 2 metres

with e the unit vector to the goal and n the number of people in the group. b is the semi-minor axis of the ellipse
whose foci are the object's position now and `STEP` seconds later, relative to the pedestrian: an object that approaches
acts from afar, one that moves along hardly acts. Objects behind the pedestrian count by a share.
For an object straight ahead the force also has a part to the side, to the right if neither side is better. Without it
two people who meet head-on would only slow each other down.

Sources: D. Helbing, P. Molnar, Social force model for pedestrian dynamics, Phys. Rev. E 51, 1995 (v0, tau, V, s, the
field of view). A. Johansson, D. Helbing, P. Shukla, Specification of the social force pedestrian model by evolutionary
adjustment to video tracking data, Adv. Complex Systems 10, 2007 (the share behind, relative motion).
M. Moussaid, N. Perozo, S. Garnier, D. Helbing, G. Theraulaz, The walking behaviour of pedestrian social groups and its
impact on crowd dynamics, PLoS ONE 5, 2010 (the form of g). `STEP`, `ATTRACTION` and the part to the side are our own
choice.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from intellwheels_agents.differential_drive import wrapped
from intellwheels_agents.portable_math import atan2, cos, exp, hypot, sincos
from intellwheels_agents.pure_pursuit import Point
from intellwheels_agents.range_ring import NearObject, bearing_sincos

PREFERRED_SPEED = 1.34
"""v0, m/s."""
RELAXATION = 0.5
"""tau, s."""
POTENTIAL = 2.1
"""V, m2/s2."""
REACH = 0.3
"""s, m."""
STEP = 1.5
"""How far the motion of other objects is extrapolated, s."""
ATTRACTION = 1.0
"""A, m/s2."""
HALF_DEPTH = 0.2
"""Distance from the surface of a person to the centre, m."""
BEHIND = 0.1
"""The share of its force with which an object outside the field of view acts."""
HALF_FIELD_OF_VIEW = math.radians(100.0)
"""Half of the field of view, to each side of the walking direction."""
TO_THE_RIGHT = math.radians(5.0)
"""An object up to this far to the right counts as straight ahead."""


def drive(wanted: Point, velocity: Point) -> Point:
    """Return the force (m/s2) that drives a velocity to the wanted one (both m/s)."""
    return (wanted[0] - velocity[0]) / RELAXATION, (wanted[1] - velocity[1]) / RELAXATION


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


def repulsion(objects: Iterable[NearObject], wanted: Point, commanded: Point, actual: Point, heading: float) -> Point:
    """Return the sum of the forces of all near objects, m/s2.

    Args:
        objects: The near objects.
        wanted: The preferred velocity, m/s; 0 if the pedestrian wants to stand.
        commanded: The pedestrian's velocity as last decided, m/s.
        actual: The pedestrian's velocity as measured, m/s.
        heading: The pedestrian's heading, rad; the walking direction of one who stands.
    """
    speed = hypot(*wanted)
    direction = atan2(wanted[1], wanted[0]) if speed > 0.0 else heading
    push_x = push_y = 0.0
    for each in objects:
        off = wrapped(each.bearing - direction)
        force, away_x, away_y = elliptic(each, actual)
        if speed > 0.0 and abs(off) > HALF_FIELD_OF_VIEW:
            force *= BEHIND
        to_y, to_x = bearing_sincos(each.bearing)
        closing = (commanded[0] - each.velocity_x) * to_x + (commanded[1] - each.velocity_y) * to_y
        if speed > 0.0 and closing > 0.0 and abs(off) < math.pi / 2.0:
            # Pass the object on the side where it is not. The side that follows from the ellipse changes with what is
            # seen of the object, and the pedestrian would sway.
            away_x, away_y = -to_x, -to_y
            beside = direction + math.copysign(math.pi / 2.0, -off - TO_THE_RIGHT)
            aside = force * cos(off) * min(closing / speed, 1.0)
            beside_y, beside_x = sincos(beside)
            push_x += aside * beside_x
            push_y += aside * beside_y
        push_x += force * away_x
        push_y += force * away_y
    return push_x, push_y


def elliptic(near: NearObject, velocity: Point) -> tuple[float, float, float]:
    """Return the elliptic force of an object on a pedestrian with a velocity (m/s).

    Returns:
        Its size (m/s2), and x and y of the unit vector of its direction.
    """
    middle = near.metres + HALF_DEPTH
    s, c = bearing_sincos(near.bearing)
    x, y = -middle * c, -middle * s
    step_x, step_y = STEP * (near.velocity_x - velocity[0]), STEP * (near.velocity_y - velocity[1])
    later_x, later_y = x - step_x, y - step_y
    later = max(hypot(later_x, later_y), 1e-6)
    half_axis = math.sqrt(max((middle + later) * (middle + later) - step_x * step_x - step_y * step_y, 0.0)) / 2.0
    force = POTENTIAL / REACH * exp(-half_axis / REACH)
    # The normal of the ellipse bisects the angle between the directions to its two foci.
    away_x, away_y = x / middle + later_x / later, y / middle + later_y / later
    length = hypot(away_x, away_y)
    if length < 0.05:
        # Straight in the path of the object: step to the right, as seen from the object.
        step = max(hypot(step_x, step_y), 1e-6)
        return force, step_y / step, -step_x / step
    return force, away_x / length, away_y / length
