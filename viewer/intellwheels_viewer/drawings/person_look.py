"""A person of the declared size, arms at the sides; the nose shows the heading, and the legs move with the gait."""

from __future__ import annotations

from intellwheels_schemas.messages import Robot
from intellwheels_schemas.rules import parts_of
from intellwheels_viewer import palette
from intellwheels_viewer.drawings.body_look import BodyLook, Leg, extent
from intellwheels_viewer.drawings.solids import Solid, ball, both, ellipses, join

_SKIN = (214, 176, 148)
_HAIR = (82, 60, 46)


def person(robot: Robot, *, crowd: bool = False) -> BodyLook:
    """Return the look of a person as wide and as tall as the declared body.

    The proportions are those of Drillis and Contini's body segment table (New York University, 1966), rounded.
    """
    hull = extent(parts_of(robot))
    (x, _), depth, width, tall = hull.middle, hull.length / 2, hull.width / 2, hull.top
    sides = 8 if crowd else 16
    torso = ellipses(
        [
            (0.47 * tall, x, 0.0, 0.55 * depth, 0.56 * width),
            (0.55 * tall, x, 0.0, 0.60 * depth, 0.60 * width),
            (0.63 * tall, x, 0.0, 0.52 * depth, 0.54 * width),
            (0.76 * tall, x, 0.0, 0.64 * depth, 0.74 * width),
            (0.81 * tall, x, 0.0, 0.52 * depth, 0.76 * width),
            (0.84 * tall, x, 0.0, 0.28 * depth, 0.34 * width),
        ],
        sides,
    )
    arm = ellipses(
        [
            (0.44 * tall, x + 0.25 * depth, 0.86 * width, 0.20 * depth, 0.13 * width),
            (0.60 * tall, x, 0.86 * width, 0.26 * depth, 0.14 * width),
            (0.79 * tall, x, 0.84 * width, 0.30 * depth, 0.16 * width),
            (0.82 * tall, x, 0.78 * width, 0.16 * depth, 0.10 * width),
        ],
        sides // 2,
    )
    leg = ellipses(
        [
            (0.03 * tall, x, 0.32 * width, 0.32 * depth, 0.20 * width),
            (0.28 * tall, x, 0.32 * width, 0.36 * depth, 0.23 * width),
            (0.49 * tall, x, 0.29 * width, 0.48 * depth, 0.30 * width),
        ],
        sides // 2,
    )
    shoe = ellipses(
        [
            (0.0, x + 0.25 * depth, 0.32 * width, 0.74 * depth, 0.22 * width),
            (0.05 * tall, x + 0.1 * depth, 0.32 * width, 0.45 * depth, 0.19 * width),
        ],
        sides // 2,
    )
    hip = (x, 0.3 * width, 0.48 * tall)
    limb = (leg + shoe).moved(*(-value for value in hip))
    return BodyLook(
        paint=torso + both(arm),
        dark=both(leg + shoe) if crowd else Solid(),
        leg=None if crowd else Leg(limb, (hip, (x, -hip[1], hip[2])), palette.DARK),
        more={_HAIR: _hair(x, width, tall, sides)},
        light=_head(x, depth, width, tall, sides),
        light_rgb=_SKIN,
        stripe=(x - 0.1 * depth, 0.845 * tall, 0.8 * width),
    )


def _hair(x: float, width: float, tall: float, sides: int) -> Solid:
    radius = min(0.065 * tall, 0.5 * width)
    return ellipses(
        [
            (0.90 * tall, x - 0.35 * radius, 0.0, 0.75 * radius, 0.8 * radius),
            (0.945 * tall, x - 0.18 * radius, 0.0, 1.02 * radius, 1.08 * radius),
            (0.985 * tall, x - 0.05 * radius, 0.0, 0.8 * radius, 0.78 * radius),
            (tall, x, 0.0, 0.15 * radius, 0.15 * radius),
        ],
        sides // 2 if sides < 16 else 12,
    )


def _head(x: float, depth: float, width: float, tall: float, sides: int) -> Solid:
    radius = 0.065 * tall
    head = ellipses(
        [
            (0.83 * tall, x, 0.0, 0.30 * depth, 0.22 * width),
            (0.87 * tall, x, 0.0, 0.55 * radius, 0.55 * radius),
            (0.89 * tall, x + 0.01, 0.0, 0.95 * radius, 0.82 * radius),
            (0.935 * tall, x, 0.0, 1.1 * radius, radius),
            (0.98 * tall, x, 0.0, 0.75 * radius, 0.7 * radius),
            (tall, x, 0.0, 0.15 * radius, 0.15 * radius),
        ],
        sides,
    )
    nose = ball(x + 1.12 * radius, 0.0, 0.925 * tall, 0.16 * radius, 6)
    hand = ball(x + 0.3 * depth, 0.86 * width, 0.43 * tall, 0.12 * width, 6)
    return join([head, nose, both(hand)])
