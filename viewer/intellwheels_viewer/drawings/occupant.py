"""The person who sits in a chair that a mind or a user drives. Pure.

The person fits the seat and stays in the box around the chair's parts: hands on the armrests, the right one at the
joystick, feet on the footrests. The proportions are those of Drillis and Contini's body segment table (New York
University, 1966), rounded.
"""

from __future__ import annotations

from typing import Final

from intellwheels_viewer.drawings.chair_frame import Frame, arm_ends, arm_height
from intellwheels_viewer.drawings.furniture import Painted
from intellwheels_viewer.drawings.solids import Point, Solid, ball, both, ellipses, join, taper
from intellwheels_viewer.palette import RGB

SKIN: Final[RGB] = (208, 170, 142)
HAIR: Final[RGB] = (74, 54, 42)
TROUSERS: Final[RGB] = (58, 70, 96)
SHOES: Final[RGB] = (36, 34, 36)


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


def hand(frame: Frame) -> Point:
    """Return the middle of the right hand, at the top of the joystick, in the chair's frame, in metres."""
    return arm_ends(frame)[1] + 0.02, -(frame.wide / 2 - 0.035), arm_height(frame) + 0.105


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
    knee = (min(frame.front + 0.03, frame.hull.front - 0.16), 0.105, frame.seat + 0.07 * k)
    ankle = (frame.hull.front - 0.13, 0.115, 0.20)
    parts = [taper((x, 0.085, z), knee, 0.085 * k, 0.066 * k, sides), taper(knee, ankle, 0.062 * k, 0.045, sides)]
    if joints:
        parts.append(ball(*knee, 0.067 * k, 8))
    return both(join(parts))


def _shoes(frame: Frame, sides: int) -> Solid:
    front = frame.hull.front
    middle, half = front - 0.105, 0.10
    return both(
        ellipses(
            [
                (0.126, middle, 0.115, half, 0.045),
                (0.165, middle, 0.115, half, 0.045),
                (0.21, middle - 0.03, 0.115, 0.05, 0.04),
            ],
            max(4, sides - 2),
        )
    )


def _arms(frame: Frame, sides: int, *, joints: bool) -> tuple[Solid, Solid]:
    """Return the arms to the wrists, and the hands: the left one on its armrest, the right one at the joystick."""
    k, x = size(frame), frame.rear + 0.28
    side = frame.wide / 2 - 0.045
    start, end = arm_ends(frame)
    top = arm_height(frame)
    elbow_x = min(start + 0.12, x + 0.06)
    sleeves, hands = [], []
    right = hand(frame)
    for y, palm in ((side, (end - 0.03, side, top + 0.035)), (-side, (right[0] - 0.035, right[1], right[2] + 0.005))):
        shoulder: Point = (x, 0.17 * k * (1 if y > 0 else -1), frame.seat + 0.515 * k)
        elbow: Point = (elbow_x, y, top + 0.05)
        wrist: Point = tuple(e + 0.86 * (p - e) for e, p in zip(elbow, palm, strict=True))  # type: ignore[assignment]
        sleeves += [taper(shoulder, elbow, 0.055 * k, 0.042, sides), taper(elbow, wrist, 0.041, 0.032, sides)]
        hands.append(ball(*palm, 0.04, 6 if joints else 4))
        if joints:
            sleeves += [ball(*shoulder, 0.06 * k, 8), ball(*elbow, 0.043, 6)]
    return join(sleeves), join(hands)
