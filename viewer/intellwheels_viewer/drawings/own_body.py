"""What drivers see of themselves: hands with fingers, cuffs and shoes. Pure.

These cover the plain hands and shoes of the person whom everybody sees. The sizes of a hand are rounded from those of
an adult: 0.19 m long and 0.085 m wide.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from intellwheels_viewer.drawings.chair_frame import Frame
from intellwheels_viewer.drawings.furniture import Painted, merged
from intellwheels_viewer.drawings.occupant import FOOT, SKIN, palms, wrists
from intellwheels_viewer.drawings.solids import Point, Solid, both, box, ellipses, join, solid, tube
from intellwheels_viewer.palette import DARK, RGB

NAIL: Final[RGB] = (240, 208, 192)
CUFF: Final[RGB] = (240, 242, 246)
SHOE: Final[RGB] = (150, 74, 44)
SOLE: Final[RGB] = (246, 246, 242)
PIVOT: Final = 0.03
"""Height of the joystick's pivot above the armrest, in metres."""


class _Finger(NamedTuple):
    """A finger of the right hand: where it begins in the frame of the palm, its radius and its three bones, metres."""

    x: float
    y: float
    radius: float
    bones: tuple[float, float, float]


_FINGERS: Final = (
    _Finger(0.036, 0.031, 0.0100, (0.042, 0.026, 0.020)),
    _Finger(0.042, 0.010, 0.0103, (0.046, 0.029, 0.021)),
    _Finger(0.038, -0.011, 0.0097, (0.042, 0.027, 0.020)),
    _Finger(0.028, -0.031, 0.0085, (0.033, 0.020, 0.018)),
)
"""From the index finger to the little one."""

_Pose = Sequence[tuple[float, tuple[float, float, float]]]
"""The turn of each finger to the left, and how far each bone points down, in degrees."""

_GRASPING: Final[_Pose] = ((-4.0, (2.0, 22.0, 42.0)), (-4.0, (6.0, 34.0, 62.0)), (-8.0, (8.0, 38.0, 66.0)),
                           (-16.0, (10.0, 40.0, 66.0)))  # fmt: skip
_RESTING: Final[_Pose] = ((7.0, (4.0, 14.0, 24.0)), (1.0, (6.0, 18.0, 30.0)), (-5.0, (6.0, 20.0, 34.0)),
                          (-14.0, (8.0, 22.0, 36.0)))  # fmt: skip
_THUMB_AT_KNOB: Final = (
    (-0.024, 0.028, -0.003), (0.004, 0.062, 0.003), (0.034, 0.084, 0.009), (0.056, 0.082, 0.010),
)  # fmt: skip
_THUMB_ASIDE: Final = (
    (-0.024, 0.028, -0.004), (0.004, 0.054, -0.006), (0.032, 0.066, -0.010), (0.055, 0.070, -0.013),
)  # fmt: skip


def grip() -> Painted:
    """Return the joystick with the right hand at it, its pivot at the origin."""
    boot = ellipses([(0.0, 0.0, 0.0, 0.034, 0.034), (0.02, 0.0, 0.0, 0.022, 0.022), (0.05, 0.0, 0.0, 0.014, 0.014)], 10)
    hand = _hand(_GRASPING, _THUMB_AT_KNOB)
    return {rgb: each.moved(-0.055, -0.055, 0.075) for rgb, each in hand.items()} | {DARK: boot}


def rest_of(frame: Frame) -> Painted:
    """Return what does not move with the joystick, in the chair's frame: the left hand, cuffs and shoes."""
    left, right = palms(frame)
    hand = {rgb: each.mirrored().moved(*left) for rgb, each in _hand(_RESTING, _THUMB_ASIDE).items()}
    cuffs = [_cuff(wrist, palm) for wrist, palm in zip(wrists(frame), (left, right), strict=True)]
    return merged(hand, {CUFF: join(cuffs)}, {rgb: both(each) for rgb, each in _shoe(frame.hull.front).items()})


def _hand(pose: _Pose, thumb: Sequence[Point]) -> Painted:
    """Return a right hand around the middle of its palm, palm down, fingers along x."""
    back = tube(
        [(-0.068, 0.0, -0.004), (-0.045, 0.0, 0.0), (-0.005, 0.0, 0.004), (0.030, 0.0, 0.003), (0.046, 0.0, 0.0)],
        [(0.026, 0.020), (0.034, 0.024), (0.043, 0.024), (0.043, 0.018), (0.036, 0.008)],
        10,
    )
    skin, nails = [back], []
    for finger, (turn, bends) in zip(_FINGERS, pose, strict=True):
        bones = _bones(finger, math.radians(turn), bends)
        skin.append(_digit(bones, finger.radius))
        nails.append(_nail(bones[-2], bones[-1], finger.radius))
    skin.append(_digit(thumb, 0.0125))
    nails.append(_nail(thumb[-2], thumb[-1], 0.0115))
    return {SKIN: join(skin), NAIL: join(nails)}


def _bones(finger: _Finger, turn: float, bends: Sequence[float]) -> list[Point]:
    x, y, z = finger.x, finger.y, 0.004
    points: list[Point] = [(x, y, z)]
    for length, bend in zip(finger.bones, bends, strict=True):
        level, down = length * math.cos(math.radians(bend)), length * math.sin(math.radians(bend))
        x, y, z = x + level * math.cos(turn), y + level * math.sin(turn), z - down
        points.append((x, y, z))
    return points


def _digit(bones: Sequence[Point], radius: float) -> Solid:
    """Return a finger with a round tip."""
    (ax, ay, az), (bx, by, bz) = bones[-2:]
    near = (ax + 0.75 * (bx - ax), ay + 0.75 * (by - ay), az + 0.75 * (bz - az))
    sizes = [radius * share for share in (1.05, 1.04, 1.0, 0.88, 0.40)]
    return tube([*bones[:-1], near, bones[-1]], [(each, each) for each in sizes], 6)


def _nail(knuckle: Point, tip: Point, radius: float) -> Solid:
    """Return a nail on the upper side of the last bone of a finger, just above the skin."""
    start, bone = np.array(knuckle), np.subtract(tip, knuckle)
    aside = np.cross((0.0, 0.0, 1.0), bone)
    aside /= np.linalg.norm(aside)
    up = radius * np.cross(bone, aside) / np.linalg.norm(bone)
    rear, front, half = start + 0.48 * bone + up, start + 0.92 * bone + 0.74 * up, 0.62 * radius * aside
    return solid([rear + half, rear - half, front - half, front + half], [(0, 1, 2), (0, 2, 3)])


def _cuff(wrist: Point, palm: Point) -> Solid:
    """Return the end of a sleeve."""
    start, reach = np.array(wrist), np.subtract(palm, wrist) / math.dist(palm, wrist)
    (x0, y0, z0), (x1, y1, z1) = (start - 0.018 * reach).tolist(), (start + 0.012 * reach).tolist()
    return tube([(x0, y0, z0), (x1, y1, z1)], [(0.0375, 0.0375), (0.0355, 0.0355)], 10)


def _shoe(front: float) -> Painted:
    """Return the left shoe on its footrest, which ends at the front of the chair."""
    y, x = FOOT, front - 0.105
    sole = ellipses([(0.126, x, y, 0.103, 0.049), (0.142, x, y, 0.103, 0.049)], 12)
    upper = ellipses(
        [
            (0.142, x - 0.002, y, 0.099, 0.046),
            (0.174, x - 0.006, y, 0.094, 0.045),
            (0.216, x - 0.036, y, 0.057, 0.041),
        ],
        12,
    )
    toe = ellipses(
        [
            (0.142, x + 0.070, y, 0.033, 0.040),
            (0.172, x + 0.068, y, 0.028, 0.034),
            (0.195, x + 0.062, y, 0.018, 0.024),
        ],
        10,
    )
    laces = [
        box(x + ahead, x + ahead + 0.008, y - 0.024, y + 0.024, height - 0.012, height)
        for ahead, height in ((0.006, 0.220), (0.022, 0.217), (0.038, 0.208))
    ]
    return {SOLE: join([sole, toe, *laces]), SHOE: upper}
