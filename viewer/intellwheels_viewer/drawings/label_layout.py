"""Where the labels of a picture stand: none overlaps another, and none covers a body while there is room. Pure.

A label stands just above its body. If another label or a body is there, it stands beside or below its body, or a little
farther up. If there is no room between the other labels, it joins the nearest one, and both become one label with the
number of their bodies. Far labels are a little smaller.
Lengths are CSS pixels, except for positions in the scene.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

Vector = npt.NDArray[np.float64]

EM: Final = 12.0
"""Font size in px of a label of scale 1, in viser."""
SCALES: Final = ((70.0, 1.1), (35.0, 1.0), (0.0, 0.92))
"""The scale of a label for a metre that is at least so many px long: 13, 12 and 11 px."""
NOUNS: Final = {"wheelchair": "chairs", "person": "people", "car": "cars", "door": "doors"}
"""The plural of a kind of body; others are bodies."""
GAP: Final = 2.0
"""Least distance between two labels."""
_LINE: Final = 1.25
"""Height of a line in em (upper bound for common fonts), and the padding of the box around it in lines."""
_PADDING: Final = 0.2
_NARROW: Final = frozenset("iljtfr.,:;'!|()[] 1-")
_WIDE: Final = frozenset("mwMW@%")
_HIGHEST: Final = 60
"""Half heights by which the label of a selected or speaking body can move up; it never joins another."""
_OUTSIDE: Final = 0.5
"""A spot partly outside the picture is as bad as half a covered body."""
_NEAR: Final = 0.2  # m; nearer than this to the camera a body has no label


class Picture(NamedTuple):
    """A camera: its position and the point that it looks at, in metres; its vertical field of view; its size in px."""

    position: tuple[float, float, float]
    look_at: tuple[float, float, float]
    fov: float
    width: float
    height: float


@dataclass(frozen=True)
class Wish:
    """A label that is wanted.

    Attributes:
        name: Its body.
        text: Its lines; empty for a body that has no label and is not to be covered.
        x, y, z: The point above the middle of the body where a label is just clear of its top, in metres.
        kind: The kind of body, see `NOUNS`.
        alone: Whether it must not join another.
        heading: That of the body, in radians.
        half: Half the length and half the width of the body, in metres.
        front: Share of its height that it has at its front, such as at the feet of who sits in a chair.
    """

    name: str
    text: str
    x: float
    y: float
    z: float
    kind: str = ""
    alone: bool = False
    heading: float = 0.0
    half: tuple[float, float] = (0.0, 0.0)
    front: float = 1.0


@dataclass(frozen=True)
class Placed:
    """A label as it stands.

    Attributes:
        names: Its bodies, one or several.
        text: Its lines.
        position: The middle of its lower edge in the scene, in metres.
        scale: Its size, see `EM`.
        box: Where it is in the picture: left, top, right, bottom in px.
    """

    names: tuple[str, ...]
    text: str
    position: tuple[float, float, float]
    scale: float
    box: tuple[float, float, float, float]


@dataclass
class _Group:
    """Labels that are one.

    Attributes:
        members: What they are of.
        at: The point above the middle of the body, or of all bodies, in metres.
        spot: Where that is in the picture.
        body: The box of the body in the picture, or the mean box of all: left, top, right, bottom.
        scale: Its size, see `EM`.
        spots: The boxes where it may stand, the best first, shape (n, 4).
        box: The one where it stands.
    """

    members: list[Wish]
    at: Vector
    spot: Vector
    body: Vector
    scale: float
    spots: Vector = field(init=False)
    box: Vector = field(init=False)

    @property
    def alone(self) -> bool:
        return self.members[0].alone

    @property
    def text(self) -> str:
        if len(self.members) == 1:
            return self.members[0].text
        kinds = {wish.kind for wish in self.members}
        noun = NOUNS.get(kinds.pop(), "bodies") if len(kinds) == 1 else "bodies"
        return f"{len(self.members)} {noun}"


def size_of(text: str, scale: float) -> tuple[float, float]:
    """Return the width and height of a label's box in px, rather too large than too small."""
    em, lines = EM * scale, text.split("\n")
    widest = max(sum(_advance(character) for character in line) for line in lines)
    padding = _PADDING * _LINE
    return em * (widest + padding), em * (_LINE * len(lines) + padding)


def _advance(character: str) -> float:
    if character in _NARROW:
        return 0.36
    if character in _WIDE:
        return 0.92
    return 0.62 if ord(character) < 0x1100 else 1.05


class Lens:
    """Turns points of the scene into points of a picture, and back at the same depth."""

    def __init__(self, picture: Picture) -> None:
        self.eye = np.array(picture.position)
        ahead = np.array(picture.look_at) - self.eye
        self.ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
        right = np.cross(self.ahead, (0.0, 0.0, 1.0))
        length = float(np.linalg.norm(right))
        self.right = right / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
        self.up = np.cross(self.right, self.ahead)
        self.middle = np.array([picture.width / 2, picture.height / 2])
        self.focal = picture.height / 2 / math.tan(picture.fov / 2)

    def depth(self, point: Vector) -> float:
        """Return how far ahead of the camera a point is, in metres."""
        return float((point - self.eye) @ self.ahead)

    def spots(self, points: Vector) -> Vector:
        """Return where points ahead of the camera are, in px from the left and from the top, shape (..., 2)."""
        away = points - self.eye
        away = away @ np.column_stack([self.right, -self.up, self.ahead])
        spots: Vector = self.middle + self.focal * away[..., :2] / away[..., 2:]
        return spots

    def moved(self, point: Vector, right: float, down: float) -> Vector:
        """Return the point that is so many px from a point in the picture, at the same depth."""
        metres = self.depth(point) / self.focal
        moved: Vector = point + metres * (right * self.right - down * self.up)
        return moved


def placed(wishes: Sequence[Wish], picture: Picture) -> list[Placed]:
    """Return the labels of a picture. No two boxes overlap; bodies outside the picture have none.

    It depends on nothing else, so that the same picture always has the same labels.
    """
    lens = Lens(picture)
    return [
        Placed(
            tuple(wish.name for wish in group.members),
            group.text,
            _position(group, lens),
            group.scale,
            tuple(group.box.tolist()),
        )
        for group in _arranged(wishes, lens, picture)
    ]


def _position(group: _Group, lens: Lens) -> tuple[float, float, float]:
    left, _, right, bottom = group.box
    x, y, z = lens.moved(group.at, (left + right) / 2 - group.spot[0], bottom - group.spot[1])
    return float(x), float(y), float(z)


def body_boxes(wishes: Sequence[Wish], lens: Lens) -> Vector:
    """Return the boxes of bodies in the picture: left, top, right, bottom in px, shape (n, 4).

    NaN for a body that is not whole ahead of the camera.
    """
    if not wishes:
        return np.empty((0, 4))
    columns = np.array([(w.x, w.y, w.z, w.heading, *w.half, w.front) for w in wishes]).T[..., None]
    x, y, z, heading, length, width, front = columns
    cos, sin = np.cos(heading), np.sin(heading)
    ahead, left = length * _CORNERS[0], width * _CORNERS[1]
    tops = z * _CORNERS[2] * np.where(_CORNERS[0] == 1.0, front, 1.0)
    points = np.stack([x + ahead * cos - left * sin, y + ahead * sin + left * cos, tops], axis=-1)
    behind = ((points - lens.eye) @ lens.ahead < _NEAR).any(axis=1)
    points[behind] = np.nan
    spots = lens.spots(points)
    return np.column_stack([spots.min(axis=1), spots.max(axis=1)])


def _arranged(wishes: Sequence[Wish], lens: Lens, picture: Picture) -> list[_Group]:
    boxes = body_boxes(wishes, lens)
    groups = [
        group
        for wish, box in zip(wishes, boxes, strict=True)
        if wish.text and (group := _group([wish], box, lens, picture)) is not None
    ]
    bodies = boxes[np.isfinite(boxes).all(axis=1)]
    _offer_spots([group for group in groups if group.alone], _AROUND + _TOWER, bodies, picture)
    _offer_spots([group for group in groups if not group.alone], _AROUND, bodies, picture)
    # Labels that stay alone come first, and the order does not change while the bodies move.
    groups.sort(key=lambda group: not group.alone)
    while (lonely := _unplaced(groups)) is not None:
        others = [group for group in groups if group is not lonely and not group.alone]
        if not others:
            groups.remove(lonely)  # there is room for the labels of the selected and the speaking only
            continue
        nearest = min(others, key=lambda group: float(np.hypot(*(group.spot - lonely.spot))))
        counts = [len(nearest.members), len(lonely.members)]
        middle: Vector = np.average([nearest.body, lonely.body], axis=0, weights=counts)
        joined = _group([*nearest.members, *lonely.members], middle, lens, picture)
        groups = [group for group in groups if group is not lonely and group is not nearest]
        if joined is not None:
            _offer_spots([joined], _AROUND, bodies, picture)
            groups.append(joined)
    return groups


def _group(members: list[Wish], body: Vector, lens: Lens, picture: Picture) -> _Group | None:
    """Return labels as one, or None outside the picture."""
    at: Vector = np.mean([(wish.x, wish.y, wish.z) for wish in members], axis=0)
    depth = lens.depth(at)
    if depth < _NEAR:
        return None
    spot = lens.spots(at)
    if not (0.0 <= spot[0] <= picture.width and 0.0 <= spot[1] <= picture.height):
        return None
    if not np.isfinite(body).all():
        body = np.concatenate([spot, spot])
    metre = lens.focal / depth
    return _Group(members, at, spot, body, next(scale for least, scale in SCALES if metre >= least))


def _offer_spots(
    groups: Sequence[_Group], places: Sequence[tuple[float, float, float]], bodies: Vector, picture: Picture
) -> None:
    """Give groups the boxes where they may stand: those that cover the least of bodies first, then as in the places."""
    if not groups:
        return
    wide, high = np.array([size_of(group.text, group.scale) for group in groups]).T[..., None]
    left, top, right, bottom = np.array([group.body for group in groups]).T[..., None]
    side, up, more = np.array(places).T
    middle = np.clip(np.array([group.spot[:1] for group in groups]), left, right)
    x = middle + side * (np.where(side > 0.0, right - middle, middle - left) + wide / 2 + GAP)
    y = (top + bottom) / 2 - up * (bottom - top + high) / 2 - np.copysign(more, up) * (high / 2 + GAP)
    spots = np.stack([x - wide / 2, y - high / 2, x + wide / 2, y + high / 2], axis=-1)
    area = wide * high
    covered = _overlap(spots, bodies).sum(axis=-1) / area
    covered += _OUTSIDE * (1.0 - _overlap(spots, np.array([(0.0, 0.0, picture.width, picture.height)]))[..., 0] / area)
    # Rounding of sums must not decide.
    order = np.argsort(np.round(covered, 3), axis=-1, kind="stable")
    for group, own, best in zip(groups, spots, order, strict=True):
        group.spots = own[best]


def _unplaced(groups: Sequence[_Group]) -> _Group | None:
    """Place the groups one after the other, and return the first for which there is no room; None if there is none."""
    taken = np.empty((len(groups), 4))
    for count, group in enumerate(groups):
        best = 0
        if not _apart(group.spots[:1], taken[:count])[0]:  # most often the best one is free
            free = _apart(group.spots, taken[:count])
            best = int(free.argmax())
            if not free[best]:
                return group
        group.box = taken[count] = group.spots[best]
    return None


def _apart(boxes: Vector, others: Vector) -> npt.NDArray[np.bool_]:
    """Return which boxes keep a gap to all others, shape (n,)."""
    left, top, right, bottom = boxes.T[..., None]
    apart = (
        (others[:, 0] >= right + GAP)
        | (others[:, 2] <= left - GAP)
        | (others[:, 1] >= bottom + GAP)
        | (others[:, 3] <= top - GAP)
    )
    return np.asarray(apart.all(axis=1))


def _overlap(boxes: Vector, others: Vector) -> Vector:
    """Return the areas that boxes (..., 4) have in common with others (m, 4), shape (..., m)."""
    boxes = boxes[..., None, :]
    wide = np.minimum(boxes[..., 2], others[:, 2]) - np.maximum(boxes[..., 0], others[:, 0])
    high = np.minimum(boxes[..., 3], others[:, 3]) - np.maximum(boxes[..., 1], others[:, 1])
    area: Vector = np.maximum(wide, 0.0) * np.maximum(high, 0.0)
    return area


_CORNERS: Final = np.array([(i, j, k) for i in (-1.0, 0.1, 1.0) for j in (-1.0, 1.0) for k in (0.0, 1.0)]).T
"""The corners of a body: ahead, left and up, in half lengths, half widths and heights. Its front may be lower."""
_AROUND: Final = (
    (0.0, 1.0, 0.0), (0.5, 1.0, 0.0), (-0.5, 1.0, 0.0), (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 1.0),
    (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.5, 1.0, 1.0), (-0.5, 1.0, 1.0), (0.0, 1.0, 2.0),
    (1.0, -1.0, 0.0), (-1.0, -1.0, 0.0), (0.5, -1.0, 0.0), (-0.5, -1.0, 0.0), (0.0, -1.0, 1.0), (0.5, 1.0, 2.0),
    (-0.5, 1.0, 2.0), (1.4, 0.0, 0.0), (-1.4, 0.0, 0.0), (1.0, 1.0, 2.0), (-1.0, 1.0, 2.0), (0.0, 1.0, 3.0),
    (0.0, 1.0, 4.0),
)  # fmt: skip
"""Where a label may stand: how far to a side, from the middle of its body at 0 to just beside it at 1; how far up, from
just below it at -1 to just above it at 1; and half heights farther up or down."""
_TOWER: Final = tuple((0.0, 1.0, float(step)) for step in range(5, _HIGHEST))
"""Where the label of a selected or speaking body may stand too."""
