"""A car of the declared size: a low body, a glass cabin and four wheels."""

from __future__ import annotations

from intellwheels_schemas.messages import Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer.drawings.body_look import BodyLook, extent
from intellwheels_viewer.drawings.solids import Point, both, box, join, loft, rod, rounded, slab

_GLASS = (150, 172, 186)


def car(robot: Robot) -> BodyLook:
    """Return the look of a car that fills the box around its parts."""
    hull = extent(parts_of(robot))
    (x, y), length, width, tall = hull.middle, hull.length, hull.width, hull.top
    belt, roof = 0.58 * tall, 0.97 * tall
    wheel = min(0.22 * tall, 0.12 * length)
    body = slab(x, y, length, width, 0.55 * wheel, belt, radius=0.12 * width, bevel=0.05 * tall)

    def ring(z: float, middle: float, along: float, across: float) -> list[Point]:
        return [(px, py, z) for px, py in rounded(middle, y, along, across, 0.1 * width)]

    cabin = x - 0.06 * length
    glass = loft(
        [ring(belt - 0.01, cabin, 0.58 * length, 0.88 * width), ring(roof, cabin, 0.40 * length, 0.74 * width)]
    )
    top = slab(cabin, y, 0.40 * length, 0.74 * width, roof, tall, radius=0.1 * width, bevel=0.01)
    thick = 0.12 * width
    tyres = [
        rod((at, width / 2 - thick, wheel), (at, width / 2, wheel), wheel, 18)
        for at in (x - 0.3 * length, x + 0.3 * length)
    ]
    lamps = box(hull.front - 0.02, hull.front + 0.001, 0.28 * width, 0.42 * width, 0.34 * tall, 0.44 * tall)
    return BodyLook(
        paint=body + top,
        dark=both(join(tyres)).moved(0.0, y),
        light=glass + both(lamps).moved(0.0, y),
        light_rgb=_GLASS,
        stripe=(cabin, tall + 0.004, 0.5 * width),
    )
