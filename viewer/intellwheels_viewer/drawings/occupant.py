"""The person who sits in a chair that a mind or a user drives. Pure.

The person fits the seat and stays in the box around the chair's parts: hands on the armrests, the right one at the
joystick, feet on the footrests. The proportions are those of Drillis and Contini's body segment table (New York
University, 1966), rounded.
"""

from __future__ import annotations

import math
from typing import Final

from intellwheels_viewer.drawings.chair_frame import Frame, arm_ends, arm_height, stick
from intellwheels_viewer.drawings.furniture import Painted
from intellwheels_viewer.drawings.solids import Point, Solid, ball, both, ellipses, join, taper
from intellwheels_viewer.palette import RGB

SKIN: Final[RGB] = (208, 170, 142)
HAIR: Final[RGB] = (74, 54, 42)
TROUSERS: Final[RGB] = (58, 70, 96)
SHOES: Final[RGB] = (36, 34, 36)
FOOT: Final = 0.085
"""Metres from the middle of the chair to that of a foot."""
_HAND: Final = 0.065
"""Metres from the end of a sleeve to the middle of the palm."""


def occupant(frame: Frame, *, crowd: bool = False) -> tuple[Solid, Painted]:
    """Return a seated person: the shirt, which has the agent's colour, and the rest by colour.

    In a crowd a person has at most 200 triangles.
    """
    sides = 5 if crowd else 10
    legs = _legs(frame, 4 if crowd else 8, joints=not crowd)
    torso, head, hair = (part(frame, sides, 2 if crowd else 1) for part in (_torso, _head, _hair))
    arms, hands = _arms(frame, 3 if crowd else 7, joints=not crowd)
    if crowd:
        return torso + arms, {SKIN: head, HAIR: hair, TROUSERS: legs}
    return torso + arms, {SKIN: head + hands, HAIR: hair, TROUSERS: legs, SHOES: _shoes(frame, sides)}


def size(frame: Frame) -> float:
    """Return the size of the person as a share of one whose head is 0.80 m above the seat: what fits under the top."""
    return min(1.05, (frame.hull.top - 0.005 - frame.seat) / 0.80)


def hip(frame: Frame) -> Point:
    """Return the middle between the hips, in the chair's frame, in metres."""
    return frame.rear + 0.30, 0.0, frame.seat + 0.09 * size(frame)


def eyes(frame: Frame) -> Point:
    """Return the place between the person's eyes, in the chair's frame, in metres."""
    return frame.rear + 0.38, 0.0, frame.seat + 0.70 * size(frame)


def palms(frame: Frame) -> tuple[Point, Point]:
    """Return the middle of the left palm, on its armrest, and of the right one, behind the knob of the joystick.

    In the chair's frame, in metres.
    """
    x, y = stick(frame)
    top = arm_height(frame)
    return (arm_ends(frame)[1] - 0.07, frame.wide / 2 - 0.04, top + 0.022), (x - 0.055, y - 0.055, top + 0.105)


def wrists(frame: Frame) -> tuple[Point, Point]:
    """Return where the left and the right sleeve end, in the chair's frame, in metres."""
    left, right = (_wrist(_elbow(frame, palm[1]), palm) for palm in palms(frame))
    return left, right


def _elbow(frame: Frame, y: float) -> Point:
    side = frame.wide / 2 - 0.045
    return min(arm_ends(frame)[0] + 0.12, frame.rear + 0.34), math.copysign(side, y), arm_height(frame) + 0.05


def _wrist(elbow: Point, palm: Point) -> Point:
    share = max(0.5, 1.0 - _HAND / math.dist(elbow, palm))  # a short chair has a short arm
    x, y, z = (e + share * (p - e) for e, p in zip(elbow, palm, strict=True))
    return x, y, z


def _torso(frame: Frame, sides: int, every: int) -> Solid:
    k, x, seat = size(frame), frame.rear + 0.29, frame.seat
    return ellipses(
        [
            (seat + 0.0, x + 0.02, 0.0, 0.12, 0.16 * k),
            (seat + 0.14 * k, x, 0.0, 0.11, 0.15 * k),
            (seat + 0.40 * k, x - 0.01, 0.0, 0.115, 0.18 * k),
            (seat + 0.53 * k, x - 0.01, 0.0, 0.09, 0.19 * k),
            (seat + 0.58 * k, x - 0.005, 0.0, 0.045, 0.07 * k),
        ][::every],
        sides,
    )


def _head(frame: Frame, sides: int, every: int) -> Solid:
    k, x, seat = size(frame), frame.rear + 0.29, frame.seat
    return ellipses(
        [
            (seat + 0.55 * k, x, 0.0, 0.05, 0.05),
            (seat + 0.60 * k, x + 0.01, 0.0, 0.055, 0.05),
            (seat + 0.64 * k, x + 0.02, 0.0, 0.085, 0.065),
            (seat + 0.71 * k, x + 0.015, 0.0, 0.095, 0.075),
            (seat + 0.76 * k, x + 0.01, 0.0, 0.08, 0.068),
        ][::every],
        sides,
    )


def _hair(frame: Frame, sides: int, every: int) -> Solid:
    k, x, seat = size(frame), frame.rear + 0.29, frame.seat
    return ellipses(
        [
            (seat + 0.63 * k, x - 0.035, 0.0, 0.055, 0.06),
            (seat + 0.655 * k, x - 0.025, 0.0, 0.07, 0.07),
            (seat + 0.72 * k, x - 0.012, 0.0, 0.088, 0.083),
            (seat + 0.775 * k, x, 0.0, 0.08, 0.07),
            (seat + 0.80 * k, x, 0.0, 0.03, 0.03),
        ][::every],
        sides,
    )


def _legs(frame: Frame, sides: int, *, joints: bool) -> Solid:
    k, (x, _, z) = size(frame), hip(frame)
    knee = (min(frame.front + 0.03, frame.hull.front - 0.16), 0.165, frame.seat + 0.07 * k)
    ankle = (frame.hull.front - 0.145, FOOT, 0.20)
    parts = [taper((x, 0.085, z), knee, 0.085 * k, 0.066 * k, sides), taper(knee, ankle, 0.062 * k, 0.045, sides)]
    if joints:
        parts.append(ball(*knee, 0.067 * k, 8))
    return both(join(parts))


def _shoes(frame: Frame, sides: int) -> Solid:
    front = frame.hull.front
    middle = front - 0.105
    return both(
        ellipses(
            [
                (0.126, middle, FOOT, 0.10, 0.043),
                (0.160, middle, FOOT, 0.093, 0.042),
                (0.205, middle - 0.035, FOOT, 0.05, 0.036),
            ],
            max(4, sides - 2),
        )
    )


def _arms(frame: Frame, sides: int, *, joints: bool) -> tuple[Solid, Solid]:
    """Return the arms to the wrists, and the hands: the left one on its armrest, the right one at the joystick."""
    k = size(frame)
    sleeves, hands = [], []
    for palm, wrist in zip(palms(frame), wrists(frame), strict=True):
        shoulder: Point = (frame.rear + 0.28, math.copysign(0.17 * k, palm[1]), frame.seat + 0.515 * k)
        elbow = _elbow(frame, palm[1])
        sleeves += [taper(shoulder, elbow, 0.055 * k, 0.042, sides), taper(elbow, wrist, 0.041, 0.032, sides)]
        hands.append(_mitten(palm, 8 if joints else 4))
        if joints:
            sleeves += [ball(*shoulder, 0.06 * k, 8), ball(*elbow, 0.043, 6)]
    return join(sleeves), join(hands)


def _mitten(palm: Point, sides: int) -> Solid:
    x, y, z = palm
    rows = ((-0.017, 0.028, 0.022), (0.0, 0.044, 0.034), (0.017, 0.030, 0.024))
    return ellipses([(z + up, x, y, half, wide) for up, half, wide in rows], sides)
